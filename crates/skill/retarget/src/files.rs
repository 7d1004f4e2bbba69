//! Files of human motion.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use paid_motion::{is_points_file, read_points, refuse_git_lfs};

use crate::bvh::parse_bvh_at;
use crate::points::{motion_of_points, parse_skeleton};
use crate::recognize::{Unit, recognize};
use crate::text::LARGEST;
use crate::{HumanMotion, RetargetError, Setting, TEXT_UNIT_M, parse_amc, parse_asf};

/// What files of human motion leave open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HumanOptions {
    /// Meters of a unit of length of a BVH file [default: 0.01, or what a leg says], of an AMC file [default: what its ASF states, or what a leg
    /// says] or of points [default: what the TOML says, else recognized].
    pub unit_m: Option<f64>,
    /// Frames a second of an AMC file [default: 120] or of points [default: what the files say]. A BVH file states its
    /// own; another takes its place and is noted.
    pub fps: Option<f64>,
    /// The ASF file of an AMC file, or the TOML file of points [default: the one beside it, see [`read_human`]]. A BVH file has its own; another
    /// is an error.
    pub skeleton: Option<PathBuf>,
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Whether a file is taken for human motion, by its name or its first word.
pub fn is_human_file(path: &Path) -> bool {
    let points = || is_points_file(path).unwrap_or(false);
    has_extension(path, "bvh") || has_extension(path, "amc") || begins_as_bvh(path) || points()
}

fn begins_as_bvh(path: &Path) -> bool {
    let mut head = Vec::new();
    // What cannot be opened is reported by whoever reads it.
    let _ = fs::File::open(path).and_then(|f| f.take(64).read_to_end(&mut head));
    String::from_utf8_lossy(&head).trim_start().starts_with("HIERARCHY")
}

/// Reads a file of human motion: BVH, AMC with its ASF, or an NPZ archive with positions of points ([`paid_motion::read_points`]) and
/// the TOML file that describes them ([`parse_skeleton`]).
///
/// Meters or millimeters in a BVH file of centimeters, another unit than an ASF file states, and z up where the format has y are recognized by
/// the length of a leg and the way of the trunk, if the bones' names are known, and said in [`HumanMotion::notes`]. A leg that has a human's
/// length in none of these units is refused.
///
/// The skeleton of `10_01.amc` is `10_01.asf` or `10.asf` in the same folder,
/// or the only ASF file there; that of points is found likewise.
///
/// # Errors
/// File, line, column, what was expected and what was found.
pub fn read_human(path: &Path, options: &HumanOptions) -> Result<HumanMotion, RetargetError> {
    if let Some(unit) = options.unit_m
        && !(1e-6..=1e3).contains(&unit)
    {
        return Err(option(Setting::Unit, "0.000001 to 1000 m", unit));
    }
    if let Some(fps) = options.fps
        && !(1.0..=2000.0).contains(&fps)
    {
        return Err(option(Setting::FileRate, "1 to 2000 Hz", fps));
    }
    if has_extension(path, "amc") {
        let asf = match &options.skeleton {
            Some(asf) => asf.clone(),
            None => skeleton_beside(path, "asf")?,
        };
        let mut skeleton = parse_asf(&text(&asf)?, &asf)?;
        let unit = options.unit_m.map_or(Unit::Usual(skeleton.unit_m), Unit::Told);
        skeleton.unit_m = unit.meters();
        recognize(parse_amc(&text(path)?, path, &skeleton, options.fps.unwrap_or(120.0))?, unit)
    } else if is_points_file(path)? {
        let file = match &options.skeleton {
            Some(file) => file.clone(),
            None => skeleton_beside(path, "toml")?,
        };
        let skeleton = parse_skeleton(&text(&file)?, &file)?;
        motion_of_points(path, &read_points(path)?, &skeleton, options)
    } else if is_human_file(path) {
        if let Some(skeleton) = &options.skeleton {
            return Err(RetargetError::OwnSkeleton { path: path.to_owned(), given: skeleton.clone() });
        }
        let unit = options.unit_m.map_or(Unit::Usual(TEXT_UNIT_M), Unit::Told);
        recognize(parse_bvh_at(&text(path)?, path, unit.meters(), options.fps)?, unit)
    } else {
        Err(RetargetError::Extension { path: path.to_owned() })
    }
}

fn option(option: Setting, expected: &'static str, found: f64) -> RetargetError {
    RetargetError::Option { option, expected, found: found.to_string() }
}

fn text(path: &Path) -> Result<String, RetargetError> {
    let io = |source| RetargetError::Io { path: path.to_owned(), source };
    let large = |found| RetargetError::Large { path: path.to_owned(), most: LARGEST, found };
    let file = fs::File::open(path).map_err(io)?;
    let size = file.metadata().map_err(io)?.len();
    if size > LARGEST {
        return Err(large(size));
    }
    let mut bytes = Vec::new();
    file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > LARGEST {
        return Err(large(bytes.len() as u64));
    }
    refuse_git_lfs(path, &bytes)?;
    // Old files name people in other encodings; all that matters is ASCII.
    Ok(String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').to_owned())
}

fn skeleton_beside(path: &Path, extension: &str) -> Result<PathBuf, RetargetError> {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let subject = stem.split('_').next().unwrap_or_default().to_owned();
    for name in [&stem, &subject] {
        let asf = path.with_file_name(format!("{name}.{extension}"));
        if asf.is_file() {
            return Ok(asf);
        }
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut all: Vec<PathBuf> = fs::read_dir(folder)
        .map_err(|source| RetargetError::Io { path: folder.to_owned(), source })?
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|p| has_extension(p, extension))
        .collect();
    match (all.pop(), all.len()) {
        (Some(asf), 0) => Ok(asf),
        (None, _) => Err(RetargetError::Skeleton { path: path.to_owned(), found: "none".to_owned() }),
        (Some(_), others) => {
            Err(RetargetError::Skeleton { path: path.to_owned(), found: format!("{} of them", others + 1) })
        }
    }
}
