//! Times of a stage's passes.

use super::raise_clock;
use crate::device::{Device, DeviceInfo};
use crate::error::Result;
use crate::frame::{Frame, FrameTiming, PassInfo, Recorder};
use std::fmt;

/// Median and 95th percentile of a time over frames, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Spread {
    /// Half of the frames take less.
    pub median_ms: f64,
    /// 95 % of the frames take less.
    pub p95_ms: f64,
}

impl Spread {
    /// Of times in any order: the value of the nearest rank. Zeros without any.
    pub fn of(mut ms: Vec<f64>) -> Self {
        ms.sort_by(f64::total_cmp);
        let rank = |q: f64| (ms.len().saturating_sub(1) as f64 * q).round() as usize;
        let at = |q: f64| ms.get(rank(q)).copied().unwrap_or(0.0);
        Self { median_ms: at(0.5), p95_ms: at(0.95) }
    }
}

/// One pass of the table.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PassRow {
    /// Pass name.
    pub pass: String,
    /// GPU time.
    #[serde(flatten)]
    pub time: Spread,
    /// Bytes that it moves, as [`PassInfo::bytes`].
    pub bytes: u64,
    /// As [`PassInfo::bytes_are_upper_bound`].
    pub bytes_are_upper_bound: bool,
    /// Threads that it starts; 0 when it runs no kernel.
    pub threads: u64,
}

impl PassRow {
    /// The passes of `table` with their times in `frames`.
    pub fn of(table: &[PassInfo], frames: &[FrameTiming]) -> Vec<Self> {
        let row = |(index, info): (usize, &PassInfo)| {
            let same = frames.iter().filter_map(|f| f.passes.get(index).filter(|p| p.pass == info.name));
            Self {
                pass: info.name.clone(),
                time: Spread::of(same.map(|p| p.ms).collect()),
                bytes: info.bytes,
                bytes_are_upper_bound: info.bytes_are_upper_bound,
                threads: if info.runs_kernel() {
                    info.extent.into_iter().map(u64::from).product()
                } else {
                    0
                },
            }
        };
        table.iter().enumerate().map(row).collect()
    }

    /// 10^9 bytes a second at the median time; `None` where the time is too short for the device's clock or the bytes are not known.
    pub fn gb_per_s(&self) -> Option<f64> {
        let bytes = if self.bytes_are_upper_bound { 0 } else { self.bytes };
        self.per_ms(bytes).map(|rate| rate * 1e-6)
    }

    /// Million threads a second at the median time: for a pass of one ray a thread, Mrays/s.
    pub fn mthreads_per_s(&self) -> Option<f64> {
        self.per_ms(self.threads).map(|rate| rate * 1e-3)
    }

    /// Bytes in MiB, as tables show them: behind `<=` when they are an upper bound.
    pub fn mebibytes(&self) -> String {
        let bound = if self.bytes_are_upper_bound { "<= " } else { "" };
        format!("{bound}{:.2}", self.bytes as f64 / f64::from(1 << 20))
    }

    fn per_ms(&self, count: u64) -> Option<f64> {
        (self.time.median_ms > 0.0 && count > 0).then(|| count as f64 / self.time.median_ms)
    }
}

/// What [`measure`] found; its `Display` is the table.
#[derive(Clone, Debug)]
pub struct StageTimes {
    /// The device.
    pub device: DeviceInfo,
    /// Full frame in pixels.
    pub size: [u32; 2],
    /// Frames that did not count.
    pub warm_up: u32,
    /// Frames that counted.
    pub frames: u32,
    /// First to last timestamp of a frame.
    pub frame: Spread,
    /// Every pass, in order.
    pub passes: Vec<PassRow>,
}

impl StageTimes {
    /// The row of a pass.
    pub fn pass(&self, name: &str) -> Option<&PassRow> {
        self.passes.iter().find(|row| row.pass == name)
    }
}

impl fmt::Display for StageTimes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        writeln!(f, "{}, {}", self.device.name, self.device.driver_line())?;
        writeln!(f, "{width}x{height}, {} frames after {} to warm up", self.frames, self.warm_up)?;
        let name = self.passes.iter().map(|row| row.pass.chars().count()).max().unwrap_or(0).max(5);
        writeln!(
            f,
            "{:<name$}  {:>10}  {:>10}  {:>10}  {:>8}  {:>10}",
            "pass", "median ms", "p95 ms", "MiB", "GB/s", "Mthreads/s"
        )?;
        let rate = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.1}"));
        for row in &self.passes {
            writeln!(
                f,
                "{:<name$}  {:>10.4}  {:>10.4}  {:>10}  {:>8}  {:>10}",
                row.pass,
                row.time.median_ms,
                row.time.p95_ms,
                row.mebibytes(),
                rate(row.gb_per_s()),
                rate(row.mthreads_per_s()),
            )?;
        }
        writeln!(f, "{:<name$}  {:>10.4}  {:>10.4}", "frame", self.frame.median_ms, self.frame.p95_ms)
    }
}

/// Records `warm_up + frames` frames and times the last `frames` with the device's timestamps, on a GPU with its clock up.
///
/// # Errors
/// Those of `record`, and a device that fails.
pub fn measure(
    device: &Device,
    size: [u32; 2],
    warm_up: u32,
    frames: u32,
    mut record: impl FnMut(&mut Frame<'_>) -> Result<()>,
) -> Result<StageTimes> {
    let mut recorder = Recorder::new(device)?;
    for index in 0..warm_up + frames {
        // After the kernels have been compiled.
        if index == warm_up {
            raise_clock(device)?;
        }
        let mut frame = recorder.begin()?;
        record(&mut frame)?;
        frame.submit()?;
    }
    let timings = recorder.finish()?;
    let first = timings.partition_point(|timing| timing.frame < warm_up);
    let counted = &timings[first..];
    Ok(StageTimes {
        device: device.info().clone(),
        size,
        warm_up,
        frames,
        frame: Spread::of(counted.iter().map(|f| f.gpu_ms).collect()),
        passes: PassRow::of(recorder.pass_table(), counted),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_is_by_nearest_rank() {
        let shuffled = (0..101u32).map(|i| f64::from(i * 37 % 101)).collect();
        assert_eq!(Spread::of(shuffled), Spread { median_ms: 50.0, p95_ms: 95.0 });
        assert_eq!(Spread::of(vec![3.0]), Spread { median_ms: 3.0, p95_ms: 3.0 });
        assert_eq!(Spread::of(Vec::new()), Spread::default());
    }

    #[test]
    fn rates_are_at_the_median() {
        let time = Spread { median_ms: 2.0, p95_ms: 9.0 };
        let row =
            PassRow { pass: "p".into(), time, bytes: 4_000_000, bytes_are_upper_bound: false, threads: 1000 };
        assert_eq!(row.gb_per_s(), Some(2.0));
        assert_eq!(row.mthreads_per_s(), Some(0.5));
        assert_eq!(PassRow { time: Spread::default(), ..row.clone() }.gb_per_s(), None);
        let bounded = PassRow { bytes_are_upper_bound: true, ..row };
        assert_eq!((bounded.gb_per_s(), bounded.mebibytes()), (None, "<= 3.81".into()));
    }
}
