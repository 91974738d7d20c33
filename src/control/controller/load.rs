//! A profile from its TOML page: every fact with evidence and source, checked before use.
//!
//! A profile may build on a built-in one (`based_on = "fanuc-30i"`): facts and files it does not
//! state are taken from there. Whether a page is ours or a user's makes no difference.

use crate::control::controller::load_check::check;
use crate::control::controller::load_checklist::checklist;
use crate::control::controller::load_facts::{FactReader, evidence};
use crate::control::controller::load_files::{TemplateFinder, read_files};
use crate::control::controller::load_program::program;
use crate::control::controller::{
    Dialect, Evidence, Fact, FanucFacts, GenericFacts, IntervalForm, LineEnd, MultiplyMode, Origin,
    Profile, SiemensFacts, StraightnessForm, TableForm,
};
use crate::text::document::{Section, Source, read_page};
use crate::text::problem::{Problems, shown};
use std::cell::RefCell;

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
