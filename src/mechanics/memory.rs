//! How much memory a press may take.

/// Environment variable with the limit in GiB.
pub const VARIABLE: &str = "TIRTOUCH_MEMORY_GIB";

/// Limit where neither the variable nor the system tells, GiB.
const UNTOLD_GIB: f64 = 8.0;

/// Bytes of a GiB.
pub const GIB: f64 = 1_073_741_824.0;

/// The limit, GiB: what [`VARIABLE`] says, else the memory that is free, where the system tells (Linux: MemAvailable),
/// else 8.
pub fn limit_gib() -> f64 {
    asked().or_else(available_gib).unwrap_or(UNTOLD_GIB)
}

/// What a value of [`VARIABLE`] means; `None` where it is no positive number.
pub fn parsed(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|gib: &f64| gib.is_finite() && *gib > 0.0)
}

fn asked() -> Option<f64> {
    parsed(&std::env::var(VARIABLE).ok()?)
}

fn available_gib() -> Option<f64> {
    let told = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = told.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.split_whitespace().next()?.parse::<f64>().ok()? * 1024.0 / GIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_a_positive_number_of_gib() {
        assert_eq!(parsed(" 2.5\n"), Some(2.5));
        for text in ["", "0", "-1", "nan", "inf", "4G"] {
            assert_eq!(parsed(text), None, "{text}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn linux_tells_what_is_free() {
        assert!(available_gib().is_some_and(|gib| gib > 0.1));
    }
}
