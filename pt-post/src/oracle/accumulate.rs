/// Running mean of one channel of one pixel, in the arithmetic of `accumulate.comp`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningMean {
    /// What the channel holds.
    pub mean: f32,
    /// What rounding left out of `mean`.
    pub residual: f32,
    /// Samples so far.
    pub count: f32,
}

impl RunningMean {
    /// With one more sample; non-finite ones are left out.
    pub fn with(self, x: f32) -> Self {
        if !x.is_finite() {
            return self;
        }
        let count = self.count + 1.0;
        let change = ((x - self.mean) - self.residual) / count + self.residual;
        let mean = self.mean + change;
        let taken = mean - self.mean;
        let residual = (self.mean - (mean - taken)) + (change - taken);
        Self { mean, residual, count }
    }
}
