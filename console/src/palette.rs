//! Colours of pictures. Robots have the hues that the recorder gives them in the log, so that both look alike.

/// Colour of the robot with this number, as SVG writes it.
pub(crate) fn robot(number: usize) -> String {
    robot_with_value(number, 0.82)
}

/// The same colour, darker: for what is drawn on top of it.
pub(crate) fn robot_dark(number: usize) -> String {
    robot_with_value(number, 0.55)
}

fn robot_with_value(number: usize, value: f64) -> String {
    let hue_deg = 32.0 + (0.58 + number as f64 * 0.618_034).fract() * 283.0;
    let channel = |offset: f64| {
        let k = (offset + hue_deg / 60.0) % 6.0;
        let level = value - value * 0.72 * k.min(4.0 - k).clamp(0.0, 1.0);
        (level * 255.0).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", channel(5.0), channel(3.0), channel(1.0))
}

pub(crate) const NOT_YET: &str = "#c9c9c9";
pub(crate) const GAP: &str = "#d62728";
pub(crate) const WALL: &str = "#2b2b33";
pub(crate) const STATION: &str = "#f2b200";
pub(crate) const ZONE: &str = "#7a003c";

/// Wraps a text in the colour of a terminal, if colours are wanted.
pub(crate) fn paint(text: &str, code: &str, colour: bool) -> String {
    if colour && !text.is_empty() { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
}

pub(crate) const BOLD: &str = "1";
pub(crate) const DIM: &str = "2";
pub(crate) const RED: &str = "31";
pub(crate) const GREEN: &str = "32";
pub(crate) const YELLOW: &str = "33";
pub(crate) const CYAN: &str = "36";
