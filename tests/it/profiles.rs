//! Every built-in profile: its facts have a source, what is assumed has a consequence, its files can be made.
use crate::shortage::job;
use crate::support::{self, fixtures, own_profile, shown, source};
use nonius::control::controller::{
    Dialect, EmittedFile, Evidence, Mechanism, Profile, ProfileSource, Role, Statement,
    StraightnessForm, builtin, load,
};
use std::collections::BTreeSet;

fn all() -> Vec<Profile> {
    let read = |id| builtin::profile(id).unwrap_or_else(|p| panic!("{id}: {}", p.render()));
    builtin::ids().into_iter().map(read).collect()
}

#[test]
fn every_built_in_profile_loads_under_its_own_id() {
    let ids: Vec<String> = all().into_iter().map(|profile| profile.id).collect();
    assert_eq!(ids, builtin::ids());
    assert!(all().iter().all(|profile| profile.origin == ProfileSource::BuiltIn));
    let pages = std::fs::read_dir(fixtures("../controllers")).unwrap();
    let pages = pages.filter(|page| page.as_ref().unwrap().path().is_file());
    assert_eq!(pages.count(), ids.len(), "a page in controllers/ is not built in");
}

/// It is stated once, has a source, and says what happens if it is assumed and wrong.
#[test]
fn every_fact_has_a_source_and_what_was_executed_names_the_control_that_ran_it() {
    for profile in all() {
        let facts = &profile.statements;
        assert!(!facts.is_empty(), "{}", profile.id);
        for fact in facts {
            let name = format!("{}: {}", profile.id, fact.fact);
            assert!(!fact.source.trim().is_empty(), "{name} has no source");
            assert!(!fact.value.trim().is_empty(), "{name} has no value");
            let consequence = fact.consequence.as_deref().unwrap_or("").trim();
            let is_assumed = fact.evidence == Evidence::Assumed;
            assert!(!is_assumed || !consequence.is_empty(), "{name} has no consequence");
            let is_named = fact.source.starts_with("LinuxCNC 2.9.0~pre1");
            assert!(is_named || fact.evidence != Evidence::Executed, "{name}: {}", fact.source);
        }
        let names: BTreeSet<&str> = facts.iter().map(|s| s.fact.as_str()).collect();
        assert_eq!(names.len(), facts.len(), "{}", profile.id);
        let was_executed = facts.iter().any(|fact| fact.evidence == Evidence::Executed);
        assert_eq!(was_executed, profile.id.starts_with("linuxcnc"), "{}", profile.id);
    }
}

/// Both table forms of a Siemens control, everything that a kit can hold.
#[test]
fn every_template_renders() {
    let errors = "axis,direction,position_mm,ex_um,ey_um,ez_um\n\
        x,+,0,0,0,0\nx,+,100,3,1,2\nx,-,0,-2,0,0\nx,-,100,1,1,2\n\
        y,,0,0,0,0\ny,,100,1,4,-1\n\
        z,,0,0,0,0\nz,,100,-2,1,5\n";
    for profile in all() {
        let mut rendered = BTreeSet::new();
        for policy in ["mean", "two-tables"] {
            let policy = format!("backlash = \"{policy}\"");
            let (_, kit) = support::generate(&job(&profile.id, &policy, 0.0, 25.0), errors);
            for file in &kit.files {
                let name = format!("{}: {}", profile.id, file.path);
                let text = std::str::from_utf8(&file.bytes).unwrap();
                let text = &text.replace('\0', ""); // the high bytes of UTF-16
                rendered.insert(file.path.clone());
                if file.role == Role::Checklist || file.path.ends_with(".html") {
                    assert!(!text.contains("{{") && !text.contains('\r'), "{name}");
                    continue; // for people: any character, line ends of every computer
                }
                assert!(text.is_ascii(), "{name} holds more than ASCII");
                assert!(!text.contains("{{") && !text.contains("{%"), "{name}: {text}");
                let end = profile.line_end.value.text();
                assert!(text.ends_with(end), "{name} does not end with a line end");
                assert!(!text.replace(end, "").contains(['\r', '\n']), "{name} mixes line ends");
            }
        }
        // One form of straightness has points.
        let is_of_its_form = |file: &EmittedFile| match (&profile.dialect, file.mechanism) {
            (Dialect::Fanuc(facts), Some(form @ (Mechanism::FourPoint | Mechanism::PerPoint))) => {
                let of_points = facts.straightness_form.value == StraightnessForm::PerPoint;
                of_points == (form == Mechanism::PerPoint)
            }
            _ => true,
        };
        for file in &profile.files {
            let is_meant = file.role != Role::Rollback && is_of_its_form(file);
            let is_there = rendered.iter().any(|path| file.is_called(path));
            assert!(is_there || !is_meant, "{}: {} was not rendered", profile.id, file.path);
        }
    }
}

fn of_page(page: &str) -> Profile {
    let template = |name: &str, is_own: bool| (!is_own).then(|| builtin::template(name))?;
    let page = source("own.toml", page);
    shown(load::profile(page, ProfileSource::BuiltIn, &template, &builtin::page))
}

/// Facts of the page itself decide which files of the page below are written, and what is not stated stays.
#[test]
fn a_page_is_laid_over_the_one_it_builds_on() {
    let keys = "[facts.table_form]\nvalue = \"data\"\nevidence = \"manual\"\nsource = \"a page\"\n\
        [facts.cec_sign]\nvalue = \"as_correction\"\nevidence = \"executed\"\nsource = \"a proof\"\n\
        [program]\nextension = \"SPF\"\n";
    let (own, base) =
        (of_page(&own_profile("siemens-828d", keys)), builtin::profile("siemens-828d").unwrap());
    assert!(own.files.iter().any(|file| file.path.ends_with(".INI")));
    assert!(base.files.iter().all(|file| !file.path.ends_with(".INI")));
    assert_eq!(own.checklist, base.checklist);
    assert_eq!(own.program.as_ref().unwrap().extension, "SPF");
    let named = |(own, base): (&Statement, &Statement)| own.fact == base.fact;
    assert_eq!(own.statements.len(), base.statements.len());
    assert!(own.statements.iter().zip(&base.statements).all(named));
    let [sign, tables] = ["cec_sign", "cec_tables"].map(|name| {
        let place = base.statements.iter().position(|s| s.fact == name).unwrap();
        (&own.statements[place], &base.statements[place])
    });
    assert_eq!((sign.0.value.as_str(), &sign.0.consequence), ("as_correction", &None));
    assert_eq!(sign.0.mechanism, sign.1.mechanism);
    assert_eq!(tables.0, tables.1);
}

/// Half an origin: fixtures/cases/refuses/profile.txt. Facts that pages once had to state are taken, and shown.
#[test]
fn a_step_without_an_origin_is_a_rule_of_this_program() {
    let keys = "[[checklist]]\npart = \"Before\"\ntext = \"Read it out.\"\n";
    let own = of_page(&own_profile("klipper-skew", keys));
    let step = &own.checklist[0].text;
    assert_eq!(step.source, "a rule of this program, not of the control");
    assert_eq!(step.evidence, Evidence::Manual);
}
