//! Colours: one per robot, the same in every picture, none of them red; red means unreachable.

use foxglove::messages::Color;

/// Red, green, blue, alpha.
pub(super) type Rgba = [u8; 4];

pub(super) const NOT_YET: Rgba = [150, 150, 150, 90];
pub(super) const UNREACHABLE: Rgba = [214, 39, 40, 230];
pub(super) const LOST: Rgba = [90, 0, 60, 230];
pub(super) const NOTHING: Rgba = [0, 0, 0, 0];
pub(super) const WALL: Rgba = [40, 40, 48, 255];
pub(super) const FLOOR: Rgba = [236, 236, 232, 255];
pub(super) const STATION: Rgba = [255, 200, 0, 255];

const PALE: u8 = 70;

/// Colour of the robot with this number. Hues lie a golden section apart, so that neighbours differ.
pub(super) fn robot(number: usize) -> Rgba {
    let share = (0.58 + number as f64 * 0.618_034).fract();
    let [red, green, blue] = from_hue(32.0 + share * 283.0, 0.72, 0.82);
    [red, green, blue, 255]
}

/// The same colour for ground that is assigned and not yet covered.
pub(super) fn pale([red, green, blue, _]: Rgba) -> Rgba {
    [red, green, blue, PALE]
}

/// As viewers take it.
pub(super) fn color(rgba: Rgba) -> Color {
    let [r, g, b, a] = rgba.map(|channel| f64::from(channel) / 255.0);
    Color { r, g, b, a }
}

fn from_hue(hue_deg: f64, saturation: f64, value: f64) -> [u8; 3] {
    let channel = |offset: f64| {
        let k = (offset + hue_deg / 60.0) % 6.0;
        let level = value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0);
        (level * 255.0).round() as u8
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_robot_looks_like_unreachable_ground_or_like_another() {
        let colours: Vec<Rgba> = (0..24).map(robot).collect();
        let distance = |a: Rgba, b: Rgba| {
            (0..3).map(|at| (f64::from(a[at]) - f64::from(b[at])).powi(2)).sum::<f64>().sqrt()
        };
        for (number, &colour) in colours.iter().enumerate() {
            assert!(distance(colour, UNREACHABLE) > 80.0, "robot {number} is red: {colour:?}");
            assert!(!colours[..number].contains(&colours[number]), "robot {number} looks like another");
        }
    }
}
