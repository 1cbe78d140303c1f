//! Arguments of `pt compare`.

use crate::args::values::numbers;
use clap::Args;
use pt_image::metrics::SequenceMetric;
use std::path::PathBuf;
use std::str::FromStr;

/// `pt compare`
#[derive(Clone, Debug, Args)]
pub struct CompareArgs {
    /// The image: PNG, JPEG, HDR or EXR. Or a sequence: a folder of such images with the number of the frame in their names, or one name with a
    /// run of # for the number.
    pub a: PathBuf,
    /// Its reference, of the same size. The frames of two sequences are compared number by number.
    pub b: PathBuf,
    /// What to measure; the formulas are printed with the values. Besides the defaults there is z-test, for EXR files
    /// with the variance of the mean in a layer `variance`. temporal_pixel and temporal_block are of sequences: how much the change from
    /// frame to frame differs from that of the reference, along the layers motion and view_depth if an EXR has them
    /// [default of images: relmse,mse,psnr,ssim,flip,hdr-flip,energy,detail]
    /// [default of sequences: relmse,flip,energy,detail,temporal_pixel,temporal_block]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub metric: Vec<MetricName>,
    /// Compare only this rectangle; x and y count from the top left pixel.
    #[arg(long, value_name = "x,y,w,h")]
    pub region: Option<Region>,
    /// False-colour map of the per-pixel error of the first metric, dark (0) to bright; of two images.
    #[arg(long, value_name = "F.png")]
    pub heatmap: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// Fail (exit code 1) when the metric, of sequences its mean over the frames, is above the value; may be repeated.
    #[arg(long, value_name = "METRIC=VALUE", help_heading = "Checks")]
    pub max: Vec<Limit>,
    /// Fail (exit code 1) when the metric is below the value (psnr, ssim, energy, detail, z-test); may be repeated.
    #[arg(long, value_name = "METRIC=VALUE", help_heading = "Checks")]
    pub min: Vec<Limit>,
}

impl CompareArgs {
    /// The metrics asked for (without any `defaults`), then those that only a limit names, each once.
    pub(super) fn metrics(&self, defaults: &[SequenceMetric]) -> Vec<SequenceMetric> {
        let mut metrics = Vec::new();
        let named = self.metric.iter().map(|&MetricName(metric)| metric);
        let defaults = defaults.iter().copied().filter(|_| self.metric.is_empty());
        let limited = self.max.iter().chain(&self.min).map(|limit| limit.metric);
        for metric in named.chain(defaults).chain(limited) {
            if !metrics.contains(&metric) {
                metrics.push(metric);
            }
        }
        metrics
    }
}

/// A [`SequenceMetric`] by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MetricName(pub SequenceMetric);

impl std::fmt::Display for MetricName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.name())
    }
}

impl FromStr for MetricName {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        text.parse().map(Self).map_err(|error: pt_image::metrics::MetricError| error.to_string())
    }
}

/// A rectangle of pixels, not empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x: u32,
    /// First row, from the top.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FromStr for Region {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |text: &str| text.parse::<u32>().map_err(|error| error.to_string());
        let [x, y, width, height] = numbers(text, "four whole numbers x,y,w,h", parse)?;
        if width == 0 || height == 0 {
            return Err(format!("the region is empty ({width}x{height} pixels)"));
        }
        Ok(Self { x, y, width, height })
    }
}

/// A bound on a metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The metric.
    pub metric: SequenceMetric,
    /// The last value that passes; not NaN.
    pub value: f64,
}

impl FromStr for Limit {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("expected METRIC=VALUE, for example relmse=0.001")?;
        let MetricName(metric) = name.parse()?;
        match value.parse::<f64>() {
            Ok(value) if !value.is_nan() => Ok(Self { metric, value }),
            _ => Err(format!("{value:?} is not a number")),
        }
    }
}
