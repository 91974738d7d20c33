//! Lists what is compiled into the program: every profile and every template of their folders.

use std::path::Path;
use std::{env, fs, io};

/// Name of the list, folder, ending of its files.
const LISTS: [(&str, &str, &str); 3] = [
    ("PROFILES", "controllers", ".toml"),
    ("BASES", "controllers/base", ".toml"),
    ("TEMPLATES", "templates", ".tera"),
];

fn main() -> io::Result<()> {
    let mut lists = String::new();
    for (list, folder, ending) in LISTS {
        println!("cargo:rerun-if-changed={folder}");
        let files = fs::read_dir(folder)?.map(|file| file.map(|file| file.file_name()));
        let names = files.collect::<io::Result<Vec<_>>>()?;
        let mut names: Vec<_> = names.iter().filter_map(|name| name.to_str()).collect();
        names.retain(|name| name.ends_with(ending) && !name.starts_with('.'));
        names.sort_unstable_by_key(|name| name.strip_suffix(ending));
        let path = |name| fs::canonicalize(Path::new(folder).join(name));
        let text = |name| Ok(format!("({name:?}, include_str!({:?})),\n", path(name)?));
        let texts: String = names.into_iter().map(text).collect::<io::Result<_>>()?;
        lists += &format!("const {list}: &[(&str, &str)] = &[\n{texts}];\n");
    }
    let out = env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?;
    fs::write(Path::new(&out).join("built_in.rs"), lists)
}
