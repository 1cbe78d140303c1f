//! GLSL to SPIR-V at build time.
//!
//! A crate's build script calls [`Kernels`]; every kernel in its `shaders/` folder becomes a constant in
//! `$OUT_DIR/kernels.rs`. File endings: `.comp` (compute), `.trace` (a kernel that traces rays; compiled for the three
//! trace backends), `.rchit`, `.rahit`, `.rmiss`.
//!
//! Sources carry neither `#version` nor `#extension` lines: [`PRELUDE`] is put in front of all of them. `#include "x"`
//! looks beside the including file, then among generated headers (`records.glsl`, `constants.glsl`, `channels.glsl`, `dimensions.glsl`, and those added with
//! [`Kernels::header`]), then in the shared `glsl/` folder, where kernels include what lies at the top and folders hold its parts. A file is
//! included once per kernel.

use crate::{channels, constants, dimensions, records};
use glslang::{CompilerOptions, ShaderInput, ShaderSource, ShaderStage, SpirvVersion, Target, VulkanVersion};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, process};

/// What every kernel starts with.
pub const PRELUDE: &str = "#version 460
#extension GL_GOOGLE_cpp_style_line_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_shader_explicit_arithmetic_types_float16 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_ballot : require
";

/// Why a kernel did not compile.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// A source could not be read.
    #[error("{path}: {source}")]
    Read {
        /// File or folder.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// An include was not found.
    #[error(
        "{file}:{line}: no header \"{header}\" beside the file, among the generated headers or in {shared}"
    )]
    NoHeader {
        /// Including file.
        file: String,
        /// Line of the directive.
        line: usize,
        /// Name in the directive.
        header: String,
        /// Folder of the shared headers.
        shared: PathBuf,
    },
    /// glslang's messages, already as file:line.
    #[error("{kernel}, compiled as {variant}:\n{log}")]
    Glsl {
        /// Kernel file.
        kernel: String,
        /// Which trace backend, or the kernel's own stage.
        variant: &'static str,
        /// Messages.
        log: String,
    },
}

/// The ways a `.trace` kernel is compiled: file suffix, define, stage.
const TRACE_VARIANTS: [(&str, &str, ShaderStage); 4] = [
    ("compute", "TRACE_COMPUTE", ShaderStage::Compute),
    ("ray_query", "TRACE_RAY_QUERY", ShaderStage::Compute),
    ("ray_gen", "TRACE_RT_PIPELINE", ShaderStage::RayGeneration),
    ("ray_gen_reorder", "TRACE_RT_REORDER", ShaderStage::RayGeneration),
];

/// Compiles the kernels of one crate.
pub struct Kernels {
    generated: BTreeMap<String, String>,
}

impl Default for Kernels {
    fn default() -> Self {
        Self::new()
    }
}

impl Kernels {
    /// With the generated headers that every crate has.
    pub fn new() -> Self {
        let generated = [
            ("channels.glsl", channels::glsl()),
            ("constants.glsl", constants::glsl()),
            ("dimensions.glsl", dimensions::glsl()),
            ("records.glsl", records::glsl()),
        ];
        Self { generated: generated.map(|(name, text)| (name.to_owned(), text)).into() }
    }

    /// Adds a generated header, such as the crate's own push constant records.
    pub fn header(mut self, name: &str, text: String) -> Self {
        self.generated.insert(name.to_owned(), text);
        self
    }

    /// Compiles `folder` (relative to the crate) into `$OUT_DIR/kernels.rs`; on an error prints it and ends the build.
    pub fn compile(&self, folder: &str) {
        self.compile_as(folder, "kernels.rs");
    }

    /// As [`Kernels::compile`] with another name for the table, for a second folder such as a crate's test kernels.
    pub fn compile_as(&self, folder: &str, table: &str) {
        let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
        let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
        // Relative to the crate, so that a copy of the checkout with its target folder is no change.
        println!("cargo::rerun-if-changed={folder}");
        println!("cargo::rerun-if-changed={}", shared_headers().display());
        if let Err(error) = self.compile_into(&root.join(folder), &out, table) {
            eprintln!("{error}");
            process::exit(1);
        }
    }

    /// As [`Kernels::compile`] with explicit folders and errors as values.
    pub fn compile_into(&self, folder: &Path, out: &Path, table_name: &str) -> Result<(), CompileError> {
        let mut kernels: Vec<PathBuf> = fs::read_dir(folder)
            .and_then(|entries| entries.map(|e| e.map(|e| e.path())).collect())
            .map_err(|source| CompileError::Read { path: folder.into(), source })?;
        kernels.sort();
        let mut table = String::new();
        for path in kernels {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let constant = stem.to_uppercase();
            let stage = match path.extension().and_then(|e| e.to_str()) {
                Some("comp") => (ShaderStage::Compute, "Compute"),
                Some("rchit") => (ShaderStage::ClosestHit, "ClosestHit"),
                Some("rahit") => (ShaderStage::AnyHit, "AnyHit"),
                Some("rmiss") => (ShaderStage::Miss, "Miss"),
                Some("trace") => {
                    self.compile_trace(&path, &stem, out)?;
                    let code =
                        |variant: &str, stage: &str| shader_code(&stem, stage, &format!("{stem}.{variant}"));
                    writeln!(
                        table,
                        "#[doc = \"`{stem}.trace`\"]\npub const {constant}: ::pt_shaders::TraceCode = \
                         ::pt_shaders::TraceCode {{ name: \"{stem}\", compute: {}, ray_query: {}, ray_gen: {}, \
                         ray_gen_reorder: {} }};",
                        code("compute", "Compute"),
                        code("ray_query", "Compute"),
                        code("ray_gen", "RayGen"),
                        code("ray_gen_reorder", "RayGen"),
                    )
                    .expect("writing to a String");
                    continue;
                }
                _ => continue,
            };
            let spirv = self.compile_one(&path, stage.1, None, stage.0)?;
            write_spirv(&out.join(format!("{stem}.{}.spv", stage.1)), &spirv)?;
            let code = shader_code(&stem, stage.1, &format!("{stem}.{}", stage.1));
            let suffix = if stage.0 == ShaderStage::Compute {
                String::new()
            } else {
                format!("_{}", stage_suffix(stage.1))
            };
            writeln!(
                table,
                "#[doc = \"`{stem}`\"]\npub const {constant}{suffix}: ::pt_shaders::ShaderCode = {code};"
            )
            .expect("writing to a String");
        }
        let path = out.join(table_name);
        fs::write(&path, table).map_err(|source| CompileError::Read { path, source })
    }

    fn compile_trace(&self, path: &Path, stem: &str, out: &Path) -> Result<(), CompileError> {
        for (variant, define, stage) in TRACE_VARIANTS {
            let spirv = self.compile_one(path, variant, Some(define), stage)?;
            write_spirv(&out.join(format!("{stem}.{variant}.spv")), &spirv)?;
        }
        Ok(())
    }

    fn compile_one(
        &self,
        path: &Path,
        variant: &'static str,
        define: Option<&str>,
        stage: ShaderStage,
    ) -> Result<Vec<u32>, CompileError> {
        let mut text = String::from(PRELUDE);
        text.push_str(match define {
            Some("TRACE_RAY_QUERY") => "#extension GL_EXT_ray_query : require\n",
            Some("TRACE_RT_PIPELINE") => "#extension GL_EXT_ray_tracing : require\n",
            Some("TRACE_RT_REORDER") => {
                "#extension GL_EXT_ray_tracing : require\n\
                 #extension GL_NV_shader_invocation_reorder : require\n\
                 #define TRACE_RT_PIPELINE 1\n"
            }
            None if stage != ShaderStage::Compute => "#extension GL_EXT_ray_tracing : require\n",
            _ => "",
        });
        if let Some(define) = define {
            writeln!(text, "#define {define} 1").expect("writing to a String");
        }
        let source =
            fs::read_to_string(path).map_err(|source| CompileError::Read { path: path.into(), source })?;
        let mut seen = Vec::new();
        self.expand(&source, path, &mut seen, &mut text)?;

        let failed = |log: String| CompileError::Glsl { kernel: path.display().to_string(), variant, log };
        let compiler = glslang::Compiler::acquire().ok_or_else(|| failed("glslang did not start".into()))?;
        let options = CompilerOptions {
            target: Target::Vulkan {
                version: VulkanVersion::Vulkan1_3,
                spirv_version: SpirvVersion::SPIRV1_5,
            },
            ..Default::default()
        };
        let source = ShaderSource::from(text);
        let input = ShaderInput::new(&source, stage, &options, None::<&[(&str, Option<&str>)]>, None)
            .map_err(|e| failed(e.to_string()))?;
        compiler.create_shader(input).and_then(|shader| shader.compile()).map_err(|e| failed(e.to_string()))
    }

    /// Appends `source` to `text` with includes resolved; `#line` keeps messages at the original file and line.
    fn expand(
        &self,
        source: &str,
        path: &Path,
        seen: &mut Vec<PathBuf>,
        text: &mut String,
    ) -> Result<(), CompileError> {
        let file = path.display().to_string();
        writeln!(text, "#line 1 \"{file}\"").expect("writing to a String");
        for (index, line) in source.lines().enumerate() {
            let Some(header) = line.trim_start().strip_prefix("#include") else {
                text.push_str(line);
                text.push('\n');
                continue;
            };
            let header = header.trim().trim_matches('"').to_owned();
            let (header_source, header_path) =
                self.find(&header, path).ok_or_else(|| CompileError::NoHeader {
                    file: file.clone(),
                    line: index + 1,
                    header,
                    shared: shared_headers(),
                })?;
            if !seen.contains(&header_path) {
                seen.push(header_path.clone());
                self.expand(&header_source, &header_path, seen, text)?;
            }
            writeln!(text, "#line {} \"{file}\"", index + 2).expect("writing to a String");
        }
        Ok(())
    }

    fn find(&self, header: &str, includer: &Path) -> Option<(String, PathBuf)> {
        let beside = includer.with_file_name(header);
        if let Ok(text) = fs::read_to_string(&beside) {
            return Some((text, beside));
        }
        if let Some(text) = self.generated.get(header) {
            return Some((text.clone(), PathBuf::from(header)));
        }
        let shared = shared_headers().join(header);
        fs::read_to_string(&shared).ok().map(|text| (text, shared))
    }
}

/// Folder of the GLSL headers that several crates include.
pub fn shared_headers() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("glsl")
}

fn stage_suffix(stage: &str) -> &'static str {
    match stage {
        "ClosestHit" => "CLOSEST_HIT",
        "AnyHit" => "ANY_HIT",
        _ => "MISS",
    }
}

fn shader_code(name: &str, stage: &str, file: &str) -> String {
    format!(
        "::pt_shaders::ShaderCode {{ name: \"{name}\", stage: ::pt_shaders::Stage::{stage}, \
         spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}.spv\")) }}"
    )
}

fn write_spirv(path: &Path, spirv: &[u32]) -> Result<(), CompileError> {
    let bytes: Vec<u8> = spirv.iter().flat_map(|word| word.to_le_bytes()).collect();
    fs::write(path, bytes).map_err(|source| CompileError::Read { path: path.into(), source })
}
