//! What the cells of a study show: scenes, cameras, and ground truth that was recorded. All of it is checked before anything is rendered.

use crate::args::{CameraArgs, CameraChoice, LookAt};
use crate::session::{choose_camera, open_scene};
use anyhow::{Context, Result, ensure};
use pt_core::capture::folder::CaptureFolder;
use pt_import::LoadOptions;
use pt_scene::{BUILTIN, PhysicalSky, Scene};
use pt_study::cell::Cell;
use pt_study::file::{Against, Study};
use std::collections::BTreeSet;
use std::path::Path;

/// A scene, as the importer takes it, or another thing that may be a file relative to the study file.
pub fn scene_path(study: &Study, scene: &str) -> String {
    let beside = study.path.parent().unwrap_or(Path::new("")).join(scene);
    if beside.is_file() { beside.to_string_lossy().into_owned() } else { scene.into() }
}

/// Whether a camera of a study is the way of one, a file.
pub fn is_camera_path(camera: &str) -> bool {
    Path::new(camera).extension().is_some_and(|ending| ending == "json")
}

/// The physical sky of the study.
///
/// # Errors
/// A text that is none, with its place in the study file.
fn sky(study: &Study) -> Result<Option<PhysicalSky>> {
    let parse = |text: &String| text.parse().map_err(|error: String| study.error_at("sky", 0, error));
    Ok(study.sky.as_ref().map(parse).transpose()?)
}

/// Opens a scene of the study at the time of its first frame.
///
/// # Errors
/// Those of the importer.
pub fn open(study: &Study, scene: &str) -> Result<Scene> {
    let options = LoadOptions { time: study.time, sky: sky(study)?, ..LoadOptions::default() };
    open_scene(&scene_path(study, scene), &options)
}

/// The camera of a cell.
///
/// # Errors
/// None in practice: a name is any text.
pub fn camera_args(study: &Study, camera: &str) -> Result<CameraArgs> {
    let default = CameraArgs::default();
    if camera.is_empty() {
        return Ok(default);
    }
    if is_camera_path(camera) {
        return Ok(CameraArgs { camera_path: Some(scene_path(study, camera).into()), ..default });
    }
    if let Ok(look) = camera.parse::<LookAt>() {
        return Ok(CameraArgs { look: Some(look), ..default });
    }
    let choice: CameraChoice = camera.parse().map_err(anyhow::Error::msg)?;
    Ok(CameraArgs { camera: Some(choice), ..default })
}

/// The capture whose references are the ground truth.
///
/// # Errors
/// A folder that is none or of another version; a frame that is measured and not there, or has no reference.
pub fn recorded(study: &Study, path: &Path) -> Result<CaptureFolder> {
    let folder = CaptureFolder::open(path)?;
    for frame in study.measure.clone() {
        let place = frame.checked_sub(folder.range().start).map(|i| i as usize);
        let entry = place.and_then(|i| folder.index.frames.get(i));
        let entry = entry.with_context(|| {
            let there = folder.range();
            format!(
                "{}: has the frames {}..{}, and the study measures {frame}",
                path.display(),
                there.start,
                there.end
            )
        })?;
        ensure!(
            entry.reference.is_some(),
            "{}: frame {frame} has no reference; record it with pt capture --reference-spp",
            path.display()
        );
    }
    Ok(folder)
}

/// Checks that all scenes are there, that those of the cells have the cameras of the cells, and that a capture is of the same scene and size. Scenes
/// are opened only where that is needed, since large ones take time.
///
/// # Errors
/// The first that is wrong, with its place in the study file.
pub fn check(study: &Study, cells: &[Cell]) -> Result<()> {
    sky(study)?;
    let capture = match &study.against {
        Against::Capture(path) => {
            let wrong = |error: anyhow::Error| study.error_at("against", 0, format!("{error:#}"));
            Some((recorded(study, path).map_err(wrong)?, path.display()))
        }
        Against::Reference { .. } => None,
    };
    for (i, name) in study.scenes.iter().enumerate() {
        let is_builtin = BUILTIN.iter().any(|(builtin, _)| builtin == name);
        let is_there = is_builtin || Path::new(&scene_path(study, name)).is_file();
        let of_scene = cells.iter().filter(|cell| cell.scene == *name);
        let cameras: BTreeSet<&str> = of_scene.map(|cell| cell.camera.as_str()).collect();
        let is_needed =
            cameras.iter().any(|camera| !camera.is_empty()) || (capture.is_some() && !cameras.is_empty());
        if is_there && !is_needed {
            continue;
        }
        let scene = open(study, name).map_err(|error| study.error_at("scenes", i, format!("{error:#}")))?;
        for (k, camera) in
            study.cameras.iter().enumerate().filter(|(_, name)| cameras.contains(name.as_str()))
        {
            choose_camera(&scene, &camera_args(study, camera)?)
                .map_err(|error| study.error_at("cameras", k, format!("{error:#}")))?;
        }
        if let Some((folder, capture)) = &capture
            && folder.index.scene != scene.name
        {
            let reason = format!(
                "{capture}: is of the scene {}, the study of {}; give a capture of the same scene",
                folder.index.scene, scene.name
            );
            return Err(study.error_at("against", 0, reason).into());
        }
    }
    for ((folder, capture), cell) in
        capture.iter().flat_map(|capture| cells.iter().map(move |cell| (capture, cell)))
    {
        let [[w, h], [cw, ch]] = [folder.index.output_size, cell.size];
        if [w, h] != [cw, ch] {
            let reason = format!(
                "{capture}: has frames of {w}x{h}, the study of {cw}x{ch}; give a capture of the same size"
            );
            return Err(study.error_at("against", 0, reason).into());
        }
    }
    Ok(())
}
