//! The profiles and templates that are compiled into the program.

use crate::controller::{Origin, Profile, load};
use crate::document::Source;
use crate::problem::{Problem, Problems, nearest};

macro_rules! embed {
    ($folder:literal, $($name:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../../", $folder, "/", $name)))),+]
    };
}

/// Built-in profiles, a profile after those it builds on.
const PROFILES: &[(&str, &str)] = embed!(
    "controllers",
    "siemens-840d-sl.toml",
    "siemens-828d.toml",
    "fanuc-30i.toml",
    "fanuc-0i-f.toml",
    "fanuc-16i.toml",
    "generic.toml",
);

const TEMPLATES: &[(&str, &str)] = embed!(
    "templates",
    "siemens-eec.mpf.tera",
    "siemens-cec.mpf.tera",
    "siemens-eec.ini.tera",
    "siemens-cec.ini.tera",
    "siemens-memory.txt.tera",
    "siemens-enable.mpf.tera",
    "siemens-disable.mpf.tera",
    "siemens-program.mpf.tera",
    "fanuc-parameters.txt.tera",
    "fanuc-points.txt.tera",
    "fanuc-program.nc.tera",
    "generic.csv.tera",
    "generic.json.tera",
);

/// Ids of the built-in profiles, in the order of `controllers list`.
pub fn ids() -> Vec<&'static str> {
    PROFILES
        .iter()
        .map(|(file, _)| file.trim_end_matches(".toml"))
        .collect()
}

/// The TOML page of a built-in profile.
pub fn page(id: &str) -> Option<&'static str> {
    PROFILES
        .iter()
        .find(|(file, _)| file.trim_end_matches(".toml") == id)
        .map(|(_, text)| *text)
}

/// The text of a built-in template.
pub fn template(name: &str) -> Option<String> {
    TEMPLATES
        .iter()
        .find(|(file, _)| *file == name)
        .map(|(_, text)| (*text).to_string())
}

/// A built-in profile by its id.
pub fn profile(id: &str) -> Result<Profile, Problems> {
    let Some(text) = page(id) else {
        let problem = Problem::new(format!("unknown controller `{id}`"));
        let list = ids().join(", ");
        return Err(problem
            .help(match nearest(id, ids()) {
                Some(near) => format!("did you mean `{near}`? built in: {list}; or give the path of a profile of your own (ending in .toml)"),
                None => format!("built in: {list}; or give the path of a profile of your own (ending in .toml)"),
            })
            .into());
    };
    let source = Source::from_bytes(&format!("controllers/{id}.toml"), text.as_bytes())?;
    load::profile(source, Origin::BuiltIn, &template, &|base| {
        profile(base).ok()
    })
}
