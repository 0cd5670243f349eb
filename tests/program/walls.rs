//! The walls of the layout: which crate may depend on which, and no circle among the files of a crate.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use serde_json::Value;
use syn::{Attribute, Item, UseTree, Visibility};

/// What is not ours, and which members may reach it; the others may not, through whatever.
const OUTSIDE: [(&[&str], &[&str]); 2] = [
    (
        &["rustdds", "ros2-client", "axum", "tokio"],
        &[
            "rustdds",
            "planesman_node",
            "planesman_watch",
            "plant_sim",
            "depth_controller",
            "dha_actuator",
            "sysid",
            "recorder",
            "planesman",
            "planesman-reports",
        ],
    ),
    (&["clap"], &["planesman", "planesman-reports"]),
];

/// A member of the workspace: its folder, what it depends on apart from its tests, what its tests depend on, and its features.
struct Member {
    folder: PathBuf,
    dependencies: Vec<String>,
    of_its_tests: Vec<String>,
    features: Vec<String>,
}

fn members() -> BTreeMap<String, Member> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--offline",
            "--format-version",
            "1",
        ])
        .current_dir(root)
        .output()
        .expect("cargo runs");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    let member = |package: &Value| {
        let manifest = PathBuf::from(text(&package["manifest_path"]));
        let folder = manifest.parent().and_then(|it| it.strip_prefix(root).ok());
        let dependencies = package["dependencies"].as_array().expect("a list");
        let (of_its_tests, dependencies): (Vec<_>, Vec<_>) =
            dependencies.iter().partition(|it| it["kind"] == "dev");
        let names = |of: Vec<&Value>| of.iter().map(|it| text(&it["name"])).collect();
        let member = Member {
            folder: folder.expect("a folder of the workspace").to_owned(),
            dependencies: names(dependencies),
            of_its_tests: names(of_its_tests),
            features: package["features"]
                .as_object()
                .expect("features")
                .keys()
                .cloned()
                .collect(),
        };
        (text(&package["name"]), member)
    };
    let packages = metadata["packages"].as_array().expect("a list");
    packages.iter().map(member).collect()
}

/// What a crate depends on, directly or through other members.
fn reach<'a>(members: &'a BTreeMap<String, Member>, name: &'a str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut open = vec![name];
    while let Some(member) = open.pop().and_then(|name| members.get(name)) {
        let new = member.dependencies.iter().map(String::as_str);
        open.extend(new.filter(|it| reached.insert(*it)));
        open.retain(|it| members.contains_key(*it));
    }
    reached
}

/// The rows of ARCHITECTURE.md's table: a folder, and the members that it stands on, without their prefix.
fn table() -> Vec<(String, Vec<String>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("ARCHITECTURE.md")).expect("the architecture");
    let rows = text
        .lines()
        .skip_while(|line| !line.contains("| depends on |"));
    let rows = rows.skip(2).take_while(|line| line.starts_with('|'));
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let [folder, _, on] = cells[..] else {
            panic!("{line}");
        };
        let folder = folder.trim_matches(['`', '/']).replace("src", "");
        let on = on.split(", ").filter(|it| !it.is_empty());
        (folder, on.map(str::to_owned).collect())
    };
    rows.map(row).collect()
}

#[test]
fn each_crate_stands_on_those_that_the_architecture_names_and_all_of_them_are_above_it() {
    let members = members();
    let short = |name: &str| name.trim_start_matches("planesman_").to_owned();
    let table = table();
    assert_eq!(table.len(), members.len(), "a row for each member");
    let mut above = Vec::new();
    for (folder, named) in table {
        let (name, member) = members
            .iter()
            .find(|(_, it)| it.folder == Path::new(&folder))
            .unwrap_or_else(|| panic!("no member is in '{folder}'"));
        let own = member.dependencies.iter();
        let own = own.filter(|it| members.contains_key(*it));
        let own: BTreeSet<String> = own.map(|it| short(it)).collect();
        assert_eq!(own, named.into_iter().collect(), "{folder}");
        let over = own.iter().find(|it| !above.contains(*it));
        assert_eq!(over, None, "{folder} stands on what is below it");
        above.push(short(name));
    }
}

/// What a user builds and tests is without the reports, which have a program of their own.
#[test]
fn no_other_member_depends_on_the_reports() {
    let reports = "planesman-reports".to_owned();
    let members = members();
    assert!(members.contains_key(&reports));
    for (name, member) in &members {
        let mut all = member.dependencies.iter().chain(&member.of_its_tests);
        assert!(!all.any(|it| *it == reports), "{name}");
    }
}

/// Base < ros < identification < vehicle < show: the place of a folder in it; `None` of what is no library.
fn trade(folder: &Path) -> Option<usize> {
    let mut parts = folder.iter().filter_map(|it| it.to_str());
    let group = match parts.next()? {
        "msgs" => "ros",
        "crates" => parts.next()?,
        _ => return None,
    };
    let order = ["base", "ros", "identification", "vehicle", "show"];
    let place = order.iter().position(|it| *it == group);
    Some(place.unwrap_or_else(|| panic!("{} is in no group", folder.display())))
}

#[test]
fn arrows_between_the_groups_of_crates_go_one_way() {
    let members = members();
    for (name, member) in &members {
        let Some(own) = trade(&member.folder) else {
            continue;
        };
        for other in &member.dependencies {
            let Some(on) = members.get(other) else {
                continue;
            };
            let is_below = trade(&on.folder).is_some_and(|it| it <= own);
            assert!(is_below, "{name} stands on {other}");
        }
    }
}

/// A build of the whole workspace, as colcon's, switches it on; one of the program alone does not where dependencies leave it
/// out, and all that stands on the member would be compiled twice.
#[test]
fn no_member_has_a_default_feature() {
    let features = |member: &Member| member.features.contains(&"default".to_owned());
    let found: Vec<String> = members()
        .into_iter()
        .filter(|(_, it)| features(it))
        .map(|it| it.0)
        .collect();
    assert_eq!(found, [""; 0]);
}

#[test]
fn only_nodes_reach_dds_and_only_the_programs_the_command_line() {
    let members = members();
    for (forbidden, allowed) in OUTSIDE {
        for name in members.keys().filter(|it| !allowed.contains(&it.as_str())) {
            let reached = reach(&members, name);
            let found = forbidden.iter().find(|it| reached.contains(*it));
            assert_eq!(found, None, "{name} reaches it");
        }
    }
}

#[test]
fn estimators_know_no_file_and_no_format_and_what_reads_them_no_estimator() {
    let members = members();
    assert!(!reach(&members, "planesman_signals").contains("planesman_identification"));
    let direct = &members["planesman_identification"].dependencies;
    for forbidden in ["csv", "mcap", "serde_json", "anyhow", "planesman_text"] {
        assert!(!direct.iter().any(|it| it == forbidden), "{forbidden}");
    }
}

/// What bloom takes a package from is the package's folder alone.
#[test]
fn a_ros_package_has_the_licences_inside() {
    let text = |path: &str| fs::read_to_string(path).expect(path);
    for package in ["msgs", "launch-scripts"] {
        let manifest = text(&format!("{package}/package.xml"));
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            assert_eq!(text(&format!("{package}/{licence}")), text(licence));
            assert!(manifest.contains(&format!("<license file=\"{licence}\">")));
        }
        assert!(text(&format!("{package}/CHANGELOG.rst")).contains("Changelog for package"));
    }
}

#[test]
fn the_files_of_a_crate_form_no_circle() {
    let mut circles = Vec::new();
    for member in members().values() {
        let root = member.folder.join("src/lib.rs");
        if root.is_file() {
            let circle = circle(&Sources::read(&root).edges());
            circles.extend(circle.map(|it| format!("{}: {it:?}", member.folder.display())));
        }
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

/// Files that lead back to the first of them, if there are any.
fn circle(edges: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    let mut edges = edges.clone();
    // A file that names none of those left is in no circle.
    loop {
        let left: BTreeSet<_> = edges.keys().cloned().collect();
        edges.retain(|_, named| {
            named.retain(|it| left.contains(it));
            !named.is_empty()
        });
        if edges.len() == left.len() {
            break;
        }
    }
    let mut path = vec![edges.keys().next()?.clone()];
    loop {
        let next = edges[path.last()?].first()?;
        if let Some(start) = path.iter().position(|it| it == next) {
            return Some(path.split_off(start));
        }
        path.push(next.clone());
    }
}

/// A path of Rust, `["sensors", "gyro"]`; from the root of the crate where it names a module.
type RustPath = Vec<String>;

/// A module in a file of its own, its tests left out.
#[derive(Default)]
struct Source {
    /// What it takes in under a name: with `pub` a re-export.
    imports: BTreeMap<String, RustPath>,
    /// What it uses itself.
    used: Vec<RustPath>,
}

/// The files of one crate.
#[derive(Default)]
struct Sources(BTreeMap<RustPath, Source>);

impl Sources {
    fn read(root: &Path) -> Self {
        let mut sources = Self::default();
        sources.add(root, root.parent().expect("a folder"), Vec::new());
        sources
    }

    /// Adds a file, and those of its modules in `folder`.
    fn add(&mut self, file: &Path, folder: &Path, module: RustPath) {
        let text = fs::read_to_string(file).expect("a source file");
        let items = syn::parse_file(&text).expect("Rust").items;
        let mut source = Source::default();
        for item in items.iter().filter(|it| !is_test(it)) {
            match item {
                Item::Mod(child) if child.content.is_none() => {
                    let name = child.ident.to_string();
                    let inner = folder.join(&name);
                    let file = [inner.with_extension("rs"), inner.join("mod.rs")];
                    let file = file
                        .iter()
                        .find(|it| it.is_file())
                        .expect("the module's file");
                    self.add(file, &inner, [module.clone(), vec![name]].concat());
                }
                Item::Use(import) => {
                    let mut names = Vec::new();
                    flatten(&import.tree, &mut Vec::new(), &mut names);
                    if matches!(import.vis, Visibility::Inherited) {
                        source
                            .used
                            .extend(names.iter().map(|(_, path)| path.clone()));
                    }
                    source.imports.extend(names);
                }
                other => paths(other.to_token_stream(), &mut source.used),
            }
        }
        self.0.insert(module, source);
    }

    /// Which file uses which.
    fn edges(&self) -> BTreeMap<String, BTreeSet<String>> {
        let edge = |(module, source): (&RustPath, &Source)| {
            let used = source
                .used
                .iter()
                .filter_map(|path| self.home(module, path));
            let used = used.filter(|it| it != module).map(|it| it.join("::"));
            (module.join("::"), used.collect())
        };
        self.0.iter().map(edge).collect()
    }

    /// The file where the thing stands that `path` names in `module`; none where it is another crate's.
    fn home(&self, module: &[String], path: &[String]) -> Option<RustPath> {
        let mut home = module.to_vec();
        let mut rest = path;
        while let [first, more @ ..] = rest {
            match first.as_str() {
                "crate" => home.clear(),
                "super" => drop(home.pop()?),
                "self" => {}
                _ => break,
            }
            rest = more;
        }
        let is_local = rest.len() < path.len();
        for (i, name) in rest.iter().enumerate() {
            let child = [home.clone(), vec![name.clone()]].concat();
            if self.0.contains_key(&child) {
                home = child;
                continue;
            }
            return match self.0[&home].imports.get(name) {
                Some(target) if is_local || i > 0 => self.home(&home, target),
                _ => (is_local || i > 0).then_some(home),
            };
        }
        Some(home)
    }
}

fn is_test(item: &Item) -> bool {
    let attributes: &[Attribute] = match item {
        Item::Mod(it) => &it.attrs,
        Item::Use(it) => &it.attrs,
        Item::Fn(it) => &it.attrs,
        Item::Impl(it) => &it.attrs,
        Item::Const(it) => &it.attrs,
        _ => &[],
    };
    let is_test =
        |it: &Attribute| it.to_token_stream().to_string().replace(' ', "") == "#[cfg(test)]";
    attributes.iter().any(is_test)
}

/// The names that a `use` takes in, each with its path.
fn flatten(tree: &UseTree, prefix: &mut RustPath, names: &mut Vec<(String, RustPath)>) {
    let mut name = |own: &syn::Ident, shown: &syn::Ident| {
        let own = own.to_string();
        let path = [prefix.clone(), vec![own.clone()]].concat();
        match own.as_str() {
            "self" => names.push((prefix.last().cloned().unwrap_or_default(), prefix.clone())),
            _ => names.push((shown.to_string(), path)),
        }
    };
    match tree {
        UseTree::Name(it) => name(&it.ident, &it.ident),
        UseTree::Rename(it) => name(&it.ident, &it.rename),
        UseTree::Path(it) => {
            prefix.push(it.ident.to_string());
            flatten(&it.tree, prefix, names);
            prefix.pop();
        }
        UseTree::Group(it) => it.items.iter().for_each(|it| flatten(it, prefix, names)),
        UseTree::Glob(_) => names.push(("*".to_owned(), prefix.clone())),
    }
}

/// Adds every path of two names and more, `a::b`, in these tokens.
fn paths(tokens: TokenStream, found: &mut Vec<RustPath>) {
    let mut path = RustPath::new();
    let mut colons = 0;
    for token in tokens {
        match &token {
            TokenTree::Punct(it) if it.as_char() == ':' => colons += 1,
            TokenTree::Ident(it) if colons == 2 && !path.is_empty() => {
                path.push(it.to_string());
                colons = 0;
            }
            _ => {
                found.extend((path.len() > 1).then(|| std::mem::take(&mut path)));
                path.clear();
                colons = 0;
                match token {
                    TokenTree::Ident(it) => path.push(it.to_string()),
                    TokenTree::Group(it) => paths(it.stream(), found),
                    _ => {}
                }
            }
        }
    }
    found.extend((path.len() > 1).then_some(path));
}
