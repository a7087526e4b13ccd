//! A scale from 0 with round numbers.

/// From values to pixels, linear, from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// Between two marks.
    pub(super) step: f64,
    /// The last mark.
    pub(super) end: f64,
}

impl Axis {
    /// A scale that holds `largest`, with about five marks. What is not a number above 0 gives a scale to 1.
    pub(super) fn up_to(largest: f64) -> Self {
        let largest = if largest.is_finite() && largest > 0.0 { largest } else { 1.0 };
        let rough = largest / 5.0;
        let magnitude = 10_f64.powf(rough.log10().floor());
        let factor =
            [1.0, 2.0, 2.5, 5.0].into_iter().find(|factor| factor * magnitude >= rough * (1.0 - 1e-9));
        let step = factor.unwrap_or(10.0) * magnitude;
        Self { step, end: (largest / step - 1e-9).ceil() * step }
    }

    /// Share of the scale that a value takes.
    pub(super) fn share(&self, value: f64) -> f64 {
        value / self.end
    }

    /// The marks with their words.
    pub(super) fn marks(&self) -> impl Iterator<Item = (f64, String)> {
        let digits = (-self.step.log10() - 1e-9).ceil().max(0.0) as usize;
        let digits =
            if (self.step * 10_f64.powi(digits as i32)).fract() > 1e-6 { digits + 1 } else { digits };
        let (step, count) = (self.step, (self.end / self.step).round() as u32);
        (0..=count).map(f64::from).map(move |mark| (mark * step, format!("{:.digits$}", mark * step)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn marks(largest: f64) -> Vec<String> {
        Axis::up_to(largest).marks().map(|(_, text)| text).collect()
    }

    #[test]
    fn marks_are_round_and_hold_the_largest_value() {
        assert_eq!(marks(8648.0), ["0", "2000", "4000", "6000", "8000", "10000"]);
        assert_eq!(marks(1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(marks(1.2), ["0.00", "0.25", "0.50", "0.75", "1.00", "1.25"]);
        assert_eq!(marks(f64::NAN), marks(1.0));
    }
}
