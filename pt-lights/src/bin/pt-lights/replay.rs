//! Gradient pixels: whether a sampler takes last frame's light samples again. Scene and camera stand still, so the light must be that of the last
//! frame, to the bit.

use super::contestant::{Choice, Contestant};
use super::measure::Plan;
use super::report::with_scene;
use super::view::View;
use anyhow::Result;
use pt_core::Recorder;
use pt_shaders::channels::{COLOR_HF, COLOR_SPEC};
use serde_json::{Value, json};
use std::io::Write;

/// What a sampler did with the pixels of its last frame.
pub struct Replayed {
    pub choice: Choice,
    /// Whether the sampler claims to repeat its choices.
    pub claims: bool,
    /// Texels that have light.
    pub lit: usize,
    /// Of the texels that were replayed in all frames, how many differ from the last frame.
    pub differ: usize,
    /// Of the texels of frames with random numbers of their own, the share that differs: what a sampler does that repeats nothing.
    pub differ_unreplayed: f64,
}

impl Replayed {
    pub fn is_equal(&self) -> bool {
        self.differ == 0 && self.lit > 0
    }

    /// Whether it does not do what it claims.
    pub fn fails(&self) -> bool {
        self.claims && !self.is_equal()
    }
}

/// Replays each frame of each sampler once. `choices` have the knob `replay`.
pub fn run(
    view: &mut View,
    choices: &[Choice],
    plan: &Plan,
    mut tell: impl FnMut(&str),
) -> Result<Vec<Replayed>> {
    let mut results = Vec::new();
    for choice in choices {
        tell(&format!("{}: {} frames, each replayed", choice.name, plan.frames));
        let mut contestant = Contestant::untimed(view, choice)?;
        let mut recorder = Recorder::new(&view.device)?;
        contestant.restart(view)?;
        let (mut lit, mut differ, mut changed, mut compared) = (0, 0, 0, 0);
        let mut last: Option<Vec<[u32; 8]>> = None;
        for step in 0..plan.frames {
            // A frame of its own, then one whose pixels all have the seed of the frame before it.
            let index = plan.warm_up + 2 * step;
            if step == 0 {
                for early in 0..plan.warm_up {
                    light(&mut contestant, view, &mut recorder, (early, plan.seed, false))?;
                }
            }
            let own = light(&mut contestant, view, &mut recorder, (index, plan.seed, false))?;
            let again = light(&mut contestant, view, &mut recorder, (index + 1, plan.seed, true))?;
            lit += own.iter().filter(|texel| texel[0..3] != [0; 3] || texel[4..7] != [0; 3]).count();
            differ += own.iter().zip(&again).filter(|(a, b)| a != b).count();
            if let Some(last) = &last {
                changed += own.iter().zip(last).filter(|(a, b)| a != b).count();
                compared += own.len();
            }
            last = Some(own);
        }
        results.push(Replayed {
            choice: choice.clone(),
            claims: choice.params.replays(),
            lit,
            differ,
            differ_unreplayed: if compared > 0 { changed as f64 / compared as f64 } else { 0.0 },
        });
    }
    Ok(results)
}

/// The bits of the light of a frame.
fn light(
    contestant: &mut Contestant,
    view: &mut View,
    recorder: &mut Recorder,
    (index, seed, replayed): (u32, u32, bool),
) -> Result<Vec<[u32; 8]>> {
    let mut frame = recorder.begin()?;
    let stage = (&contestant.stage, &contestant.choice.params);
    // Surfaces and seeds of the last frame, lit in this one.
    let surfaces = view.frame_record(if replayed { index - 1 } else { index }, seed);
    let record = view.frame_record(index, seed);
    view.record_lit(&mut frame, [&surfaces, &record], &mut contestant.lights, stage, None)?;
    frame.submit()?;
    recorder.finish()?;
    let [hf, spec] = [COLOR_HF, COLOR_SPEC].map(|id| view.images.current(id).read_f32());
    let (hf, spec) = (hf?, spec?);
    let texels = hf.chunks_exact(4).zip(spec.chunks_exact(4));
    Ok(texels
        .map(|(hf, spec)| std::array::from_fn(|i| if i < 4 { hf[i] } else { spec[i - 4] }.to_bits()))
        .collect())
}

/// Prints a line for each sampler.
pub fn table(results: &[Replayed], plan: &Plan, out: &mut impl Write) -> Result<()> {
    let width = results.iter().map(|r| r.choice.name.len()).max().unwrap_or(0).max(14);
    writeln!(
        out,
        "{} frames after {} to warm up, each replayed in the next one; scene and camera stand still",
        plan.frames, plan.warm_up
    )?;
    writeln!(
        out,
        "{:<width$} {:>10} {:>10} {:>11} {:>20}",
        "sampler", "lit", "differ", "bit-equal", "differ without replay"
    )?;
    for r in results {
        let verdict = match (r.claims, r.is_equal()) {
            (false, _) => "no claim",
            (true, true) => "yes",
            (true, false) => "NO",
        };
        writeln!(
            out,
            "{:<width$} {:>10} {:>10} {verdict:>11} {:>19.1}%",
            r.choice.name,
            r.lit,
            r.differ,
            100.0 * r.differ_unreplayed
        )?;
    }
    Ok(())
}

/// The rows for a JSON file.
pub fn rows(results: &[Replayed], plan: &Plan, view: &View) -> Vec<Value> {
    let row = |r: &Replayed| {
        let fields = json!({
            "sampler": r.choice.name,
            "claims_replay": r.claims,
            "bit_equal": r.is_equal(),
            "texels_lit": r.lit,
            "texels_differ": r.differ,
            "differ_without_replay": r.differ_unreplayed,
            "frames": plan.frames,
            "warm_up": plan.warm_up,
        });
        with_scene(view, fields)
    };
    results.iter().map(row).collect()
}
