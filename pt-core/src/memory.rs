//! Checks, before memory is taken, that it is there, and what would fit instead.

use crate::error::{Error, Result};

/// Share of the free memory that one request may take: the rest is for what is not counted.
const USABLE: f64 = 0.9;

/// Bytes of the host's memory that are free; `None` where the system does not tell.
pub fn host_free_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let free = line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok()? << 10;
    // The limit of a container; without one the file holds the word `max`.
    let limit = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let limit = limit.and_then(|text| text.trim().parse().ok());
    Some(limit.map_or(free, |limit: u64| free.min(limit)))
}

/// Checks that images of `size` pixels, which take `bytes` in all, fit into `free` bytes. `what` they are for; `place`: whose memory
/// it is.
///
/// # Errors
/// [`Error::TooLarge`], with the largest size of the same shape that fits.
pub fn check_size(
    what: &'static str,
    size: [u32; 2],
    bytes: u64,
    place: &'static str,
    free: u64,
) -> Result<()> {
    if bytes as f64 <= USABLE * free as f64 {
        return Ok(());
    }
    let side = (USABLE * free as f64 / bytes as f64).sqrt();
    let fits = size.map(|n| ((f64::from(n) * side) as u32).max(1));
    Err(Error::TooLarge { what, size, bytes, place, free, fits })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::gib;

    #[test]
    fn a_size_that_fits_is_named_and_does_fit() {
        let bytes = |[w, h]: [u32; 2]| 400 * u64::from(w) * u64::from(h);
        let free = 8 << 30;
        let size = [16384, 8192];
        let check = |size| check_size("a frame", size, bytes(size), "the device", free);
        let message = check(size).unwrap_err().to_string();
        assert_eq!(
            message,
            "a frame of 16384x8192 needs 50.0 GiB, the device has 8.0 GiB of free memory; 6217x3108 fits"
        );
        check([6217, 3108]).unwrap();
        check([6300, 3150]).unwrap_err();
    }

    #[test]
    fn the_system_tells_what_is_free() {
        if std::path::Path::new("/proc/meminfo").exists() {
            assert!(host_free_bytes().unwrap() > 1 << 20);
        }
        assert_eq!(gib(3 << 29), "1.5 GiB");
        assert_eq!(gib(3 << 20), "3 MiB");
    }
}
