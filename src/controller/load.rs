//! A profile from its TOML page: every fact with evidence and source, checked before use.
//!
//! A profile may build on a built-in one (`based_on = "fanuc-30i"`): facts and files it does not
//! state are taken from there. Whether a page is ours or a user's makes no difference.

use crate::controller::load_checklist::checklist;
use crate::controller::load_program::program;
use crate::controller::{
    Dialect, EmittedFile, Evidence, Fact, FanucFacts, GenericFacts, IntervalForm, LineEnd,
    Mechanism, MultiplyMode, NumberRange, Origin, Profile, Role, SiemensFacts, Statement,
    StraightnessForm, TableForm, TableSign,
};
use crate::document::{Section, Source, read_page};
use crate::problem::{Problem, Problems, shown};
use std::cell::RefCell;

/// Finds the text of a template by its name; `None` if there is none.
pub type TemplateFinder<'a> = &'a dyn Fn(&str) -> Option<String>;

/// Finds a built-in profile by its id.
pub type BaseFinder<'a> = &'a dyn Fn(&str) -> Option<Profile>;

/// Reads and checks a profile. All problems of the page are given at once.
pub fn profile(
    source: Source,
    origin: Origin,
    templates: TemplateFinder<'_>,
    bases: BaseFinder<'_>,
) -> Result<Profile, Problems> {
    let (profile, source) = read_page(source, |root| read_profile(root, origin, templates, bases))?;
    let problems = check(&profile, &source);
    problems.or_ok(profile)
}

fn read_profile(
    root: &Section<'_>,
    origin: Origin,
    templates: TemplateFinder<'_>,
    bases: BaseFinder<'_>,
) -> Option<Profile> {
    match root.whole("schema") {
        Some(1) => {}
        _ => root.problem(
            "schema",
            "a profile needs `schema = 1`",
            "write `schema = 1` in its first line",
        ),
    }
    let id = root.required_text("id", "a short name such as `fanuc-30i`")?;
    let name = root.required_text("name", "maker and model")?;
    let base = base_profile(root, bases)?;
    let facts = match base {
        Some(_) => root.section("facts"),
        None => root.required_section("facts"),
    };
    let base = base.as_ref();
    let reader = FactReader {
        section: facts.as_ref(),
        inherited: base.map_or(&[], |b| b.statements.as_slice()),
        statements: RefCell::default(),
    };
    let dialect = read_dialect(root, &reader, base);
    read_behaviour(&reader, base, dialect.as_ref());
    let line_end = reader.fact("line_end", base.map(|b| &b.line_end), |f| {
        f.choice(
            "value",
            &[
                ("LF", LineEnd::Lf),
                ("CR LF", LineEnd::CrLf),
                ("LF CR CR", LineEnd::LfCrCr),
            ],
        )
    });
    let comments = reader.flag("comments", base.map(|b| &b.comments));
    let axis_names = reader.fact("axis_names", base.map(|b| &b.axis_names), |f| {
        f.texts("value")
    });
    let detection_unit_required = reader.flag(
        "detection_unit_required",
        base.map(|b| &b.detection_unit_required),
    );
    if let Some(section) = &facts {
        section.refuse_unknown_keys();
    }
    let files = read_files(root, base, templates);
    let program = program(root, base.and_then(|b| b.program.as_ref()), templates);
    let checklist = checklist(root, base.map(|b| b.checklist.as_slice()));
    let display = display(root, base);
    let dialect = dialect?;
    let form = match &dialect {
        Dialect::Siemens(facts) => Some(facts.table_form.value),
        _ => None,
    };
    Some(Profile {
        id,
        name,
        origin,
        dialect,
        line_end: line_end?,
        comments: comments?,
        axis_names: axis_names?,
        detection_unit_required: detection_unit_required?,
        files: files?
            .into_iter()
            .filter(|(wanted, _)| wanted.is_none() || *wanted == form)
            .map(|(_, file)| file)
            .collect(),
        checklist: checklist?,
        display: display?,
        program: program?,
        statements: reader.statements.into_inner(),
    })
}

/// Facts that the emulators implement in one way only: a page must state that way, with source.
fn read_behaviour(reader: &FactReader<'_>, base: Option<&Profile>, dialect: Option<&Dialect>) {
    let between: &[(&'static str, ())] = match dialect {
        Some(Dialect::Fanuc(_)) => &[("step", ())],
        _ => &[("linear", ())],
    };
    let inherit = base.map(|_| Fact {
        value: (),
        evidence: Evidence::Manual,
        source: String::new(),
        consequence: None,
    });
    let inherit = inherit.as_ref();
    reader.fact("interpolation", inherit, |f| f.choice("value", between));
    reader.fact("outside", inherit, |f| f.choice("value", &[("hold", ())]));
    reader.fact("direction", inherit, |f| f.text("value").map(|_| ()));
    reader.fact("value_unit", inherit, |f| f.text("value").map(|_| ()));
}

fn base_profile(root: &Section<'_>, bases: BaseFinder<'_>) -> Option<Option<Profile>> {
    let Some(id) = root.text("based_on") else {
        return Some(None);
    };
    let base = bases(&id);
    if base.is_none() {
        root.problem(
            "based_on",
            format!(
                "`based_on` names `{}`, expected the id of a built-in profile",
                shown(&id)
            ),
            "`nonius controllers list` shows them",
        );
        return None;
    }
    Some(base)
}

fn read_dialect(
    root: &Section<'_>,
    reader: &FactReader<'_>,
    base: Option<&Profile>,
) -> Option<Dialect> {
    let stated = root.choice(
        "dialect",
        &[
            ("siemens", "siemens"),
            ("fanuc", "fanuc"),
            ("generic", "generic"),
        ],
    );
    let inherited = base.map(|b| b.dialect.word());
    let word = match (stated, inherited) {
        (Some(stated), Some(inherited)) if stated != inherited => {
            root.problem(
                "dialect",
                format!(
                    "`dialect` is `{stated}`, but the profile it builds on speaks `{inherited}`"
                ),
                "remove `dialect`, or build on another profile",
            );
            return None;
        }
        (Some(word), _) | (None, Some(word)) => word,
        (None, None) => {
            root.missing("dialect", "`siemens`, `fanuc` or `generic`");
            return None;
        }
    };
    match word {
        "siemens" => siemens_facts(reader, base).map(Dialect::Siemens),
        "fanuc" => fanuc_facts(reader, base).map(Dialect::Fanuc),
        _ => generic_facts(reader, base).map(Dialect::Generic),
    }
}

fn siemens_facts(reader: &FactReader<'_>, base: Option<&Profile>) -> Option<SiemensFacts> {
    let base = base.and_then(|b| match &b.dialect {
        Dialect::Siemens(facts) => Some(facts),
        _ => None,
    });
    let lec_sign = reader.sign("lec_sign", base.map(|b| &b.lec_sign));
    let cec_sign = reader.sign("cec_sign", base.map(|b| &b.cec_sign));
    let table_form = reader.fact("table_form", base.map(|b| &b.table_form), |f| {
        f.choice(
            "value",
            &[("program", TableForm::Program), ("data", TableForm::Data)],
        )
    });
    let lec_points = reader.whole("lec_points", base.map(|b| &b.lec_points));
    let cec_tables = reader.whole("cec_tables", base.map(|b| &b.cec_tables));
    let cec_points = reader.whole("cec_points", base.map(|b| &b.cec_points));
    let cec_memory_fixed = reader.flag("cec_memory_fixed", base.map(|b| &b.cec_memory_fixed));
    let value_decimals = reader.whole("value_decimals", base.map(|b| &b.value_decimals));
    let position_decimals = reader.whole("position_decimals", base.map(|b| &b.position_decimals));
    let cec_max_sum_um = reader.positive("cec_max_sum_um", base.map(|b| &b.cec_max_sum_um));
    let multiply_mode = reader.fact("multiply_mode", base.map(|b| &b.multiply_mode), |f| {
        f.choice(
            "value",
            &[
                ("product", MultiplyMode::Product),
                ("additive", MultiplyMode::Additive),
            ],
        )
    });
    let factor_contributes = reader.flag("factor_contributes", base.map(|b| &b.factor_contributes));
    Some(SiemensFacts {
        lec_sign: lec_sign?,
        cec_sign: cec_sign?,
        table_form: table_form?,
        lec_points: lec_points?,
        cec_tables: cec_tables?,
        cec_points: cec_points?,
        cec_memory_fixed: cec_memory_fixed?,
        value_decimals: value_decimals?,
        position_decimals: position_decimals?,
        cec_max_sum_um: cec_max_sum_um?,
        multiply_mode: multiply_mode?,
        factor_contributes: factor_contributes?,
    })
}

fn fanuc_facts(reader: &FactReader<'_>, base: Option<&Profile>) -> Option<FanucFacts> {
    let base = base.and_then(|b| match &b.dialect {
        Dialect::Fanuc(facts) => Some(facts),
        _ => None,
    });
    let pitch_sign = reader.sign("pitch_sign", base.map(|b| &b.pitch_sign));
    let straightness_sign = reader.sign("straightness_sign", base.map(|b| &b.straightness_sign));
    let number_digits = reader.whole("number_digits", base.map(|b| &b.number_digits));
    let q_identifier = reader.flag("q_identifier", base.map(|b| &b.q_identifier));
    let point_offset = reader.whole("point_offset", base.map(|b| &b.point_offset));
    let pitch_points = reader.ranges("pitch_points", base.map(|b| &b.pitch_points));
    let minus_points = reader.ranges("minus_points", base.map(|b| &b.minus_points));
    let increment_max = reader.whole("increment_max", base.map(|b| &b.increment_max));
    let magnification_max = reader.whole("magnification_max", base.map(|b| &b.magnification_max));
    let interval_form = reader.fact("interval_form", base.map(|b| &b.interval_form), |f| {
        f.choice(
            "value",
            &[
                ("real", IntervalForm::Real),
                ("integer", IntervalForm::Integer),
            ],
        )
    });
    let interval_decimals_mm = reader.whole(
        "interval_decimals_mm",
        base.map(|b| &b.interval_decimals_mm),
    );
    let interval_decimals_inch = reader.whole(
        "interval_decimals_inch",
        base.map(|b| &b.interval_decimals_inch),
    );
    let interval_feed_divisor = reader.positive(
        "interval_feed_divisor",
        base.map(|b| &b.interval_feed_divisor),
    );
    let output_fraction = reader.positive("output_fraction", base.map(|b| &b.output_fraction));
    let reversal_magnified = reader.flag("reversal_magnified", base.map(|b| &b.reversal_magnified));
    let straightness_form = reader.fact(
        "straightness_form",
        base.map(|b| &b.straightness_form),
        |f| {
            f.choice(
                "value",
                &[
                    ("four-point", StraightnessForm::FourPoint),
                    ("per-point", StraightnessForm::PerPoint),
                ],
            )
        },
    );
    let straightness_sets = reader.whole("straightness_sets", base.map(|b| &b.straightness_sets));
    let straightness_axis_points = reader.whole(
        "straightness_axis_points",
        base.map(|b| &b.straightness_axis_points),
    );
    let straightness_points =
        reader.ranges("straightness_points", base.map(|b| &b.straightness_points));
    let straightness_magnification_parameter = reader.whole(
        "straightness_magnification_parameter",
        base.map(|b| &b.straightness_magnification_parameter),
    );
    let straightness_start_parameter = reader.whole(
        "straightness_start_parameter",
        base.map(|b| &b.straightness_start_parameter),
    );
    let straightness_amount_max = reader.whole(
        "straightness_amount_max",
        base.map(|b| &b.straightness_amount_max),
    );
    Some(FanucFacts {
        pitch_sign: pitch_sign?,
        straightness_sign: straightness_sign?,
        number_digits: number_digits?,
        q_identifier: q_identifier?,
        point_offset: point_offset?,
        pitch_points: pitch_points?,
        minus_points: minus_points?,
        increment_max: increment_max?,
        magnification_max: magnification_max?,
        interval_form: interval_form?,
        interval_decimals_mm: interval_decimals_mm?,
        interval_decimals_inch: interval_decimals_inch?,
        interval_feed_divisor: interval_feed_divisor?,
        output_fraction: output_fraction?,
        reversal_magnified: reversal_magnified?,
        straightness_form: straightness_form?,
        straightness_sets: straightness_sets?,
        straightness_axis_points: straightness_axis_points?,
        straightness_points: straightness_points?,
        straightness_magnification_parameter: straightness_magnification_parameter?,
        straightness_start_parameter: straightness_start_parameter?,
        straightness_amount_max: straightness_amount_max?,
    })
}

fn generic_facts(reader: &FactReader<'_>, base: Option<&Profile>) -> Option<GenericFacts> {
    let base = base.and_then(|b| match &b.dialect {
        Dialect::Generic(facts) => Some(facts),
        _ => None,
    });
    Some(GenericFacts {
        points: reader.whole("points", base.map(|b| &b.points))?,
    })
}

/// Reads `[facts.NAME]` sections: value, evidence, source, consequence, mechanism.
pub(super) struct FactReader<'a> {
    pub(super) section: Option<&'a Section<'a>>,
    pub(super) inherited: &'a [Statement],
    pub(super) statements: RefCell<Vec<Statement>>,
}

impl FactReader<'_> {
    pub(super) fn fact<T: Clone>(
        &self,
        name: &'static str,
        base: Option<&Fact<T>>,
        value: impl FnOnce(&Section<'_>) -> Option<T>,
    ) -> Option<Fact<T>> {
        let inherited = self
            .inherited
            .iter()
            .find(|statement| statement.fact == name);
        let Some(fact) = self.section.and_then(|section| section.section(name)) else {
            if base.is_none()
                && let Some(section) = self.section
            {
                let _ = section.required_section(name);
            }
            self.statements.borrow_mut().extend(inherited.cloned());
            return base.cloned();
        };
        let stated = value(&fact);
        if !fact.has("value") {
            fact.missing("value", "what is stated");
        }
        let evidence = evidence(&fact);
        let source = fact.required_text(
            "source",
            "manual, edition and chapter, or why it is assumed",
        );
        let consequence = fact.text("consequence");
        if evidence == Some(Evidence::Assumed) && consequence.is_none() {
            fact.missing(
                "consequence",
                "what happens on the machine if the assumption is wrong",
            );
        }
        let mechanism = fact.choice("mechanism", &Mechanism::WORDS);
        fact.refuse_unknown_keys();
        let known = Fact {
            value: stated?,
            evidence: evidence?,
            source: source?,
            consequence,
        };
        self.statements.borrow_mut().push(Statement {
            fact: name.to_string(),
            value: fact
                .as_written("value")
                .unwrap_or_default()
                .trim_matches('"')
                .to_string(),
            evidence: known.evidence,
            source: known.source.clone(),
            consequence: known.consequence.clone(),
            mechanism: mechanism.or(inherited.and_then(|statement| statement.mechanism)),
        });
        Some(known)
    }

    fn sign(&self, name: &'static str, base: Option<&Fact<TableSign>>) -> Option<Fact<TableSign>> {
        self.fact(name, base, |f| {
            f.choice(
                "value",
                &[
                    ("as_error", TableSign::AsError),
                    ("as_correction", TableSign::AsCorrection),
                ],
            )
        })
    }

    fn whole(&self, name: &'static str, base: Option<&Fact<u32>>) -> Option<Fact<u32>> {
        self.fact(name, base, |f| f.whole("value"))
    }

    fn positive(&self, name: &'static str, base: Option<&Fact<f64>>) -> Option<Fact<f64>> {
        self.fact(name, base, |f| f.positive("value"))
    }

    fn flag(&self, name: &'static str, base: Option<&Fact<bool>>) -> Option<Fact<bool>> {
        self.fact(name, base, |f| f.flag("value"))
    }

    fn ranges(
        &self,
        name: &'static str,
        base: Option<&Fact<Vec<NumberRange>>>,
    ) -> Option<Fact<Vec<NumberRange>>> {
        self.fact(name, base, |f| {
            let pairs = f.whole_pairs("value")?;
            if pairs.iter().any(|[first, last]| first > last) {
                f.problem(
                    "value",
                    "a block ends before it begins",
                    "write [first, last]",
                );
                return None;
            }
            Some(
                pairs
                    .iter()
                    .map(|[first, last]| NumberRange {
                        first: *first,
                        last: *last,
                    })
                    .collect(),
            )
        })
    }
}

pub(super) fn evidence(fact: &Section<'_>) -> Option<Evidence> {
    if !fact.has("evidence") {
        fact.missing("evidence", "`manual`, `assumed` or `executed`");
    }
    fact.choice(
        "evidence",
        &[
            ("manual", Evidence::Manual),
            ("assumed", Evidence::Assumed),
            ("executed", Evidence::Executed),
        ],
    )
}

/// `[display]`: where the control shows the correction that acts; that of the base where it is not
/// stated.
fn display(root: &Section<'_>, base: Option<&Profile>) -> Option<Option<Fact<String>>> {
    let Some(section) = root.section("display") else {
        return Some(base.and_then(|b| b.display.clone()));
    };
    let value = section.required_text("value", "the name of the display");
    let source = section.required_text("source", "manual, edition and chapter, or why");
    let evidence = evidence(&section);
    let consequence = section.text("consequence");
    section.refuse_unknown_keys();
    Some(Some(Fact {
        value: value?,
        evidence: evidence?,
        source: source?,
        consequence,
    }))
}

type FormFile = (Option<TableForm>, EmittedFile);

fn read_files(
    root: &Section<'_>,
    base: Option<&Profile>,
    templates: TemplateFinder<'_>,
) -> Option<Vec<FormFile>> {
    let sections = root.sections("files");
    if sections.is_empty() {
        if let Some(base) = base {
            return Some(base.files.iter().map(|file| (None, file.clone())).collect());
        }
        root.problem(
            "files",
            "there is no section [[files]], expected one for each file",
            "add `[[files]]` with role, path and template",
        );
        return None;
    }
    let files: Vec<Option<FormFile>> = sections
        .iter()
        .map(|file| read_file(file, templates))
        .collect();
    refuse_shared_names(&sections, &files);
    files.into_iter().collect()
}

/// Two files of one name overwrite each other, unless they are forms of which one is written.
fn refuse_shared_names(sections: &[Section<'_>], files: &[Option<FormFile>]) {
    for (index, (section, file)) in sections.iter().zip(files).enumerate() {
        let Some((form, file)) = file else { continue };
        let shared = files[..index].iter().flatten().any(|(other_form, other)| {
            let both = form.is_none() || other_form.is_none() || form == other_form;
            both && other.path.eq_ignore_ascii_case(&file.path)
        });
        if shared {
            section.problem(
                "path",
                format!("two files are called `{}`", shown(&file.path)),
                "give each file a name of its own, in capitals or not",
            );
        }
    }
}

fn read_file(file: &Section<'_>, templates: TemplateFinder<'_>) -> Option<FormFile> {
    let role = file.choice(
        "role",
        &[
            ("table", Role::Table),
            ("parameters", Role::Parameters),
            ("enable", Role::Enable),
            ("disable", Role::Disable),
            ("rollback", Role::Rollback),
            ("sign-proof", Role::SignProof),
            ("checklist", Role::Checklist),
            ("report", Role::Report),
        ],
    );
    if !file.has("role") {
        file.missing(
            "role",
            "`table`, `parameters`, `enable`, `disable`, `rollback`, `sign-proof`, `checklist` or `report`",
        );
    }
    let mechanism = proved(file, role);
    let path = file.required_text("path", "a file name");
    let name = file.required_text("template", "the name of a template");
    let when = file.text("when");
    let form = file.choice(
        "form",
        &[("program", TableForm::Program), ("data", TableForm::Data)],
    );
    file.refuse_unknown_keys();
    let (role, path, name) = (role?, path?, name?);
    if !is_plain_file_name(&path) {
        file.problem(
            "path",
            format!(
                "`{}` is no file name that every control and laptop takes",
                shown(&path)
            ),
            "use letters, digits, `_`, `-` and `.`; `manifest.json` is taken",
        );
    }
    let Some(template) = templates(&name) else {
        file.problem(
            "template",
            format!("there is no template `{}`", shown(&name)),
            "put it beside the profile, or name a built-in one (docs/templates.md)",
        );
        return None;
    };
    let file = EmittedFile {
        role,
        path,
        template_name: name,
        template,
        when,
        mechanism,
    };
    Some((form, file))
}

/// The mechanism that a sign proof is for; no other file has one.
fn proved(file: &Section<'_>, role: Option<Role>) -> Option<Mechanism> {
    let proof = role == Some(Role::SignProof);
    if proof != file.has("mechanism") && role.is_some() {
        file.problem(
            if proof { "role" } else { "mechanism" },
            "`mechanism` belongs to files of the role `sign-proof`, and to each of them",
            "for instance `role = \"sign-proof\"` with `mechanism = \"cec\"`",
        );
    }
    file.choice("mechanism", &Mechanism::PROVED)
}

fn check(profile: &Profile, source: &Source) -> Problems {
    let mut problems = Problems::none();
    ensure_three_axis_names(profile, source, &mut problems);
    ensure_a_table_is_written(profile, source, &mut problems);
    ensure_sensible_numbers(profile, source, &mut problems);
    problems
}

fn ensure_three_axis_names(profile: &Profile, source: &Source, problems: &mut Problems) {
    let names = &profile.axis_names.value;
    let path = "facts.axis_names.value";
    if names.len() != 3 {
        let message = format!("`axis_names` has {} names, expected three", names.len());
        problems.push(
            source
                .problem_at(path, message)
                .help("name the axes X, Y and Z of the machine, in this order"),
        );
    }
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let other = |name: &&String| name.is_empty() || !name.chars().all(plain);
    for name in names.iter().filter(other) {
        let message = format!(
            "`{}` is no axis name, expected letters, digits and `_`",
            shown(name)
        );
        problems.push(
            source
                .problem_at(path, message)
                .help("write it as the control shows it, e.g. `AX1`"),
        );
    }
}

fn is_plain_file_name(path: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    !path.is_empty()
        && !path.starts_with('.')
        && path.chars().all(plain)
        && !path.eq_ignore_ascii_case("manifest.json")
}

fn ensure_a_table_is_written(profile: &Profile, source: &Source, problems: &mut Problems) {
    if !profile.files.iter().any(|file| file.role == Role::Table) {
        problems.push(source.problem_at(
            "files",
            "no file has the role `table`, expected at least one",
        ));
    }
}

fn ensure_sensible_numbers(profile: &Profile, source: &Source, problems: &mut Problems) {
    const MOST_DECIMALS: u32 = 9;
    let decimals = match &profile.dialect {
        Dialect::Siemens(facts) => vec![facts.value_decimals.value, facts.position_decimals.value],
        Dialect::Fanuc(facts) => {
            if facts.output_fraction.value >= 1.0 {
                problems.push(source.problem_at(
                    "facts.output_fraction.value",
                    "the place of a pulse must lie between 0 and 1",
                ));
            }
            if facts.increment_max.value == 0 || facts.magnification_max.value == 0 {
                problems.push(source.problem_at(
                    "facts",
                    "`increment_max` and `magnification_max` must be at least 1",
                ));
            }
            vec![
                facts.interval_decimals_mm.value,
                facts.interval_decimals_inch.value,
            ]
        }
        Dialect::Generic(_) => Vec::new(),
    };
    if decimals.iter().any(|d| *d > MOST_DECIMALS) {
        problems.push(Problem::new(format!(
            "`{}`: at most {MOST_DECIMALS} decimals can be written",
            source.name
        )));
    }
}
