//! Samplers that take part in a comparison.

use super::Settings;
use super::view::View;
use anyhow::{Result, ensure};
use pt_core::Recorder;
use pt_core::harness::{Spread, raise_clock};
use pt_core::settings::apply_sets;
use pt_light_sampling::LightTables;
use pt_lights::records::LightRays;
use pt_lights::{DirectLighting, DirectParams};
use pt_shaders::named_enum::NamedEnum;
use pt_shaders::records::LightSampler;
use std::time::Instant;

/// The entry without a sampler: a shadow ray for each kind of light, which is picked by its power.
pub const PER_KIND: &str = "per-kind";
/// Frames before the clock counts, in which kernels are compiled, and least frames that are timed.
const LEAST_FRAMES: usize = 6;
/// Most frames that are timed.
const TIMED_FRAMES: usize = 64;
/// Seconds after which no more frames are timed.
const TIMED_S: f64 = 2.0;
/// Passes that are the same for all samplers.
const COMMON_PASSES: [&str; 2] = ["primary rays", "composite"];

/// Passes with a thread for each pixel, or each proxy of a tile, that choose lights: what a sampler costs besides shadow rays and tables.
const CHOICE_PASSES: [&str; 4] =
    ["choose lights", "light proxies", "light reuse over time", "light reuse of neighbours"];

/// An argument of `--samplers`: a sampler, or `per-kind`, and knobs of its own, `NAME:KNOB=VALUE:...`.
#[derive(Clone, Debug)]
pub struct Entry {
    name: String,
    sampler: Option<LightSampler>,
    sets: Vec<String>,
}

impl Entry {
    /// Reads an argument; the message names what is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default();
        let sampler = match name {
            PER_KIND => None,
            _ => Some(LightSampler::from_name(name).map_err(|unknown| format!("{unknown}, or {PER_KIND}"))?),
        };
        Ok(Self { name: text.into(), sampler, sets: parts.map(|set| format!("lights.{set}")).collect() })
    }

    /// All samplers, after the baseline.
    pub fn all() -> Vec<Self> {
        let names = std::iter::once(PER_KIND).chain(LightSampler::NAMES.iter().copied());
        names.filter_map(|name| Self::parse(name).ok()).collect()
    }

    /// With the knobs that all entries share.
    pub fn choose(&self, shared: &DirectParams) -> Result<Choice> {
        let mut settings = Settings { lights: shared.clone() };
        apply_sets(&mut settings, &self.sets)?;
        let mut params = settings.lights;
        match self.sampler {
            Some(sampler) => (params.rays, params.sampler) = (LightRays::Merged, sampler),
            None => params.rays = LightRays::PerKind,
        }
        Ok(Choice { name: self.name.clone(), params })
    }
}

/// A sampler with all its knobs.
#[derive(Clone)]
pub struct Choice {
    /// As in `--samplers`.
    pub name: String,
    pub params: DirectParams,
}

impl Choice {
    fn sampler(&self) -> Option<LightSampler> {
        (self.params.rays == LightRays::Merged).then_some(self.params.sampler)
    }

    /// Random candidates of a sample, of which resampling chooses one; 1: no resampling.
    pub fn candidates(&self) -> u32 {
        match self.sampler() {
            Some(LightSampler::Ris | LightSampler::RestirDi) => self.params.ris_candidates,
            Some(LightSampler::NeeAt) => self.params.nee_at_candidates,
            _ => 1,
        }
    }

    /// What it carries from frame to frame.
    pub fn history(&self) -> &'static str {
        match self.sampler() {
            Some(LightSampler::ClusterStats) => "shadow statistics",
            Some(LightSampler::RestirDi) if self.params.restir_temporal => "reservoirs",
            Some(LightSampler::NeeAt) => "light proxies",
            _ => "none",
        }
    }

    pub fn has_history(&self) -> bool {
        self.history() != "none"
    }

    pub fn is_restir(&self) -> bool {
        self.sampler() == Some(LightSampler::RestirDi)
    }
}

/// What makes the errors of these entries hard to compare; an error if they cannot be compared at equal samples.
pub fn unequal(choices: &[Choice]) -> Result<Vec<String>> {
    for pair in choices.windows(2) {
        let [a, b] = [&pair[0], &pair[1]].map(|c| (c.params.samples, &c.name));
        ensure!(
            a.0 == b.0,
            "--samplers: {} takes {} samples a pixel and {} takes {}: give all of them the same, with --set lights.samples=N",
            a.1,
            a.0,
            b.1,
            b.0
        );
    }
    let mut notes = Vec::new();
    let resampling: Vec<&Choice> = choices.iter().filter(|c| c.candidates() > 1).collect();
    if resampling.windows(2).any(|pair| pair[0].candidates() != pair[1].candidates()) {
        let each: Vec<String> = resampling.iter().map(|c| format!("{} {}", c.name, c.candidates())).collect();
        notes.push(format!("numbers of candidates differ: {}", each.join(", ")));
    }
    Ok(notes)
}

/// A sampler with its kernels and tables.
pub struct Contestant {
    pub choice: Choice,
    pub stage: DirectLighting,
    pub lights: LightTables,
    /// Of direct lighting and what belongs to its sampler, for a frame.
    pub gpu_ms: f64,
    /// Of the passes among them that choose lights, for a frame.
    pub choose_gpu_ms: f64,
    /// Until the sampler's tables were made.
    pub build_ms: f64,
    /// Of the sampler's tables on the device.
    pub bytes: u64,
}

impl Contestant {
    /// Compiles the kernels, makes the tables and times them.
    pub fn new(view: &mut View, choice: &Choice, seed: u32) -> Result<Self> {
        let mut contestant = Self::untimed(view, choice)?;
        (contestant.gpu_ms, contestant.choose_gpu_ms) = contestant.time(view, seed)?;
        ensure!(contestant.gpu_ms > 0.0, "the device has no timestamps");
        Ok(contestant)
    }

    /// Compiles the kernels and makes the tables.
    pub fn untimed(view: &mut View, choice: &Choice) -> Result<Self> {
        let stage = DirectLighting::new(&view.device, view.gpu.variant(), &choice.params)?;
        let mut lights = LightTables::new(&view.device, &view.scene)?;
        let started = Instant::now();
        lights.keep_last_frame(choice.params.replays());
        lights.prepare(&view.device, &view.scene, &mut view.gpu, choice.params.sampler_choice())?;
        let build_ms = started.elapsed().as_secs_f64() * 1e3;
        let bytes = lights.sampler().map_or(0, |tables| tables.bytes());
        let (gpu_ms, choose_gpu_ms) = (0.0, 0.0);
        Ok(Self { choice: choice.clone(), stage, lights, gpu_ms, choose_gpu_ms, build_ms, bytes })
    }

    /// Median GPU times of a frame, of all passes and of those that choose lights, milliseconds.
    fn time(&mut self, view: &mut View, seed: u32) -> Result<(f64, f64)> {
        self.restart(view)?;
        let device = view.device.clone();
        let mut recorder = Recorder::new(&device)?;
        let mut index = 0;
        let mut record = |recorder: &mut Recorder| -> Result<()> {
            let mut frame = recorder.begin()?;
            let record = view.frame_record(index, seed);
            view.record(&mut frame, &record, &mut self.lights, (&self.stage, &self.choice.params), None)?;
            frame.submit()?;
            index += 1;
            Ok(())
        };
        for _ in 0..LEAST_FRAMES {
            record(&mut recorder)?;
        }
        recorder.finish()?;
        // The device has no pause from here on.
        raise_clock(&device)?;
        let started = Instant::now();
        for frame in 0..TIMED_FRAMES {
            if frame >= LEAST_FRAMES && started.elapsed().as_secs_f64() >= TIMED_S {
                break;
            }
            record(&mut recorder)?;
        }
        let (mut times, mut choices) = (Vec::new(), Vec::new());
        for timing in recorder.finish()? {
            let sum = |counts: &dyn Fn(&str) -> bool| -> f64 {
                timing.passes.iter().filter(|pass| counts(&pass.pass)).map(|pass| pass.ms).sum()
            };
            times.push(sum(&|pass| !COMMON_PASSES.contains(&pass)));
            choices.push(sum(&|pass| CHOICE_PASSES.contains(&pass)));
        }
        Ok((Spread::of(times).median_ms, Spread::of(choices).median_ms))
    }

    /// Forgets what the sampler has learned, and makes its tables those of the scene on the device.
    pub fn restart(&mut self, view: &mut View) -> Result<()> {
        view.images.reset_history();
        self.lights.forget()?;
        self.lights.attach(&mut view.gpu);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choices(names: &[&str]) -> Vec<Choice> {
        let shared = DirectParams::default();
        names.iter().map(|name| Entry::parse(name).unwrap().choose(&shared).unwrap()).collect()
    }

    #[test]
    fn entries_have_knobs_of_their_own() {
        let [plain, biased, kinds] =
            &choices(&["ris", "restir-di:restir_spatial=1:ris_candidates=4", PER_KIND])[..]
        else {
            panic!("three entries")
        };
        assert_eq!((plain.candidates(), plain.history()), (8, "none"));
        assert_eq!(
            (biased.candidates(), biased.params.restir_spatial, biased.history()),
            (4, 1, "reservoirs")
        );
        assert_eq!((kinds.params.rays, kinds.candidates()), (LightRays::PerKind, 1));
        assert!(Entry::parse("none").unwrap_err().contains(PER_KIND));
        let unknown = Entry::parse("ris:nothing=1").unwrap().choose(&DirectParams::default());
        assert!(unknown.is_err_and(|error| error.to_string().contains("lights.nothing")));
        assert_eq!(Entry::all().len(), LightSampler::VALUES.len() + 1);
    }

    #[test]
    fn unequal_entries_are_noted_or_refused() {
        assert!(
            unequal(&choices(&["power", "cluster-cdf", "ris", "restir-di", "nee-at"])).unwrap().is_empty()
        );
        let notes = unequal(&choices(&["ris", "power", "nee-at:nee_at_candidates=4"])).unwrap();
        assert_eq!(notes, ["numbers of candidates differ: ris 8, nee-at:nee_at_candidates=4 4"]);
        let refused = unequal(&choices(&["ris", "ris:samples=2"])).unwrap_err().to_string();
        assert!(refused.contains("ris takes 1 samples") && refused.contains("lights.samples"), "{refused}");
    }
}
