//! Bars: means with deviations, in groups, in panels side by side.

use super::{
    axis::Axis,
    sheet::{Anchor, Frame, Sheet},
};

const BAR_PX: f64 = 14.0;
const GROUP_GAP_PX: f64 = 18.0;

/// A mean and how far from it values lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Height of the bar.
    pub mean: f64,
    /// Half the length of the mark on top; 0 for none.
    pub deviation: f64,
}

/// Groups of bars under one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct BarPanel {
    /// Stands above.
    pub title: String,
    /// Word below each group, and its bars: one per series, in their order.
    pub groups: Vec<(String, Vec<Option<Bar>>)>,
}

/// Panels side by side.
#[derive(Debug, Clone, PartialEq)]
pub struct BarPlot {
    /// Stands above all.
    pub title: String,
    /// Unit of the values.
    pub unit: String,
    /// Names of the series.
    pub series: Vec<String>,
    /// The panels.
    pub panels: Vec<BarPanel>,
}

impl BarPlot {
    /// Draws it.
    pub fn svg(&self) -> String {
        let mut sheet = Sheet::new();
        for panel in &self.panels {
            self.draw(panel, &mut sheet);
        }
        sheet.finish(&self.title, &self.series)
    }

    fn draw(&self, panel: &BarPanel, sheet: &mut Sheet) {
        let group_px = self.series.len() as f64 * BAR_PX + GROUP_GAP_PX;
        let bars = panel.groups.iter().flat_map(|(_, bars)| bars.iter().flatten());
        let largest = bars.map(|bar| bar.mean + bar.deviation).fold(0.0, f64::max);
        let width_px = group_px * panel.groups.len() as f64;
        let frame = sheet.frame(&panel.title, width_px, Axis::up_to(largest));
        for (number, (word, bars)) in panel.groups.iter().enumerate() {
            let left = frame.left_px + number as f64 * group_px + GROUP_GAP_PX / 2.0;
            for (series, bar) in bars.iter().enumerate() {
                if let Some(bar) = bar {
                    self.bar(sheet, &frame, left + series as f64 * BAR_PX, series, *bar);
                }
            }
            let middle = left + (group_px - GROUP_GAP_PX) / 2.0;
            sheet.text((middle, Frame::below_px(0)), Anchor::Middle, 12, word);
        }
    }

    fn bar(&self, sheet: &mut Sheet, frame: &Frame, left_px: f64, series: usize, bar: Bar) {
        let (top, foot) = (frame.y_px(bar.mean), frame.y_px(0.0));
        let title = format!("{}: {:.1} ± {:.1} {}", self.series[series], bar.mean, bar.deviation, self.unit);
        sheet.bar((left_px + 1.0, top), (BAR_PX - 2.0, foot - top), series, &title);
        if bar.deviation > 0.0 {
            let middle = left_px + BAR_PX / 2.0;
            let ends = [bar.mean - bar.deviation, bar.mean + bar.deviation];
            sheet.line(ends.into_iter().map(|end| (middle, frame.y_px(end.max(0.0)))), "#222", 1.5);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bar_is_drawn_with_its_name_and_nothing_is_markup() {
        let bar = |mean, deviation| Some(Bar { mean, deviation });
        let plot = BarPlot {
            title: "Time < 5".to_owned(),
            unit: "s".to_owned(),
            series: vec!["lanes".to_owned(), "bc & co".to_owned()],
            panels: vec![BarPanel {
                title: "depot".to_owned(),
                groups: vec![
                    ("∞".to_owned(), vec![bar(50.0, 5.0), bar(100.0, 0.0)]),
                    ("320 s".to_owned(), vec![None, bar(25.0, 1.0)]),
                ],
            }],
        };
        let svg = plot.svg();
        assert!(svg.contains("lanes: 50.0 ± 5.0 s") && svg.contains("bc &amp; co: 25.0 ± 1.0 s"));
        assert!(svg.contains("Time &lt; 5") && !svg.contains("lanes: 25"));
        // The axis ends at 100: half of it is half the frame.
        assert!(svg.contains("height=\"120.0\"") && svg.contains("height=\"240.0\""), "{svg}");
    }
}
