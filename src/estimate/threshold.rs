//! The threshold of the paper's figures, as it is asked for.

use super::Settings;

/// Brighter pixels are lit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Threshold {
    /// Grey levels.
    Levels(f64),
    /// Per cent of the top grey level.
    Percent(f64),
}

impl Default for Threshold {
    fn default() -> Self {
        Self::Levels(Settings::default().threshold_grey)
    }
}

impl Threshold {
    /// In grey levels of an image whose top level is `top_grey`.
    pub fn of(self, top_grey: f64) -> f64 {
        match self {
            Self::Levels(levels) => levels,
            Self::Percent(percent) => 0.01 * percent * top_grey,
        }
    }

    /// The same of an image whose top level may not be known.
    ///
    /// # Errors
    /// No pixel could be lit; a share of what is not known.
    pub fn levels(self, top_grey: Option<f64>) -> Result<f64, String> {
        match (self, top_grey) {
            (_, Some(top)) if self.of(top) >= top => {
                Err(format!("a threshold of {self} is not below the top grey level of {top}: no pixel could be lit"))
            }
            (_, Some(top)) => Ok(self.of(top)),
            (Self::Levels(levels), None) => Ok(levels),
            (Self::Percent(_), None) => Err(format!(
                "has no full scale that a threshold of {self} could be a share of; give a number, or expose it by the \
                 camera of a scene"
            )),
        }
    }
}

impl std::fmt::Display for Threshold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Levels(levels) => write!(f, "{levels}"),
            Self::Percent(percent) => write!(f, "{percent}%"),
        }
    }
}

impl std::str::FromStr for Threshold {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
        match text.strip_suffix('%') {
            Some(share) => number(share).filter(|percent| *percent < 100.0).map(Self::Percent),
            None => number(text).map(Self::Levels),
        }
        .ok_or_else(|| {
            "it must be a finite number of grey levels, 0 or more, or a share below 100 % such as `2%`".into()
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_threshold_is_levels_or_a_share_of_full_scale() {
        let read = |text: &str| text.parse::<Threshold>();
        assert_eq!(read("5").unwrap().of(255.0), 5.0);
        assert_eq!(read("2%").unwrap().of(65535.0), 1310.7);
        assert_eq!(read("2%").unwrap().to_string(), "2%");
        for bad in ["", "-1", "nan", "inf", "100%", "-1%", "%"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
