//! What `nonius path` prints for scripts.

use super::holes::{Hole, length};
use super::show_path::{outside_sentences, remarks, warnings};
use super::{Followed, Page};
use crate::kit::manifest::picometres;
use crate::volume::tool_path::{Channel, Extreme};
use serde_json::{Map, Value, json};

pub(super) fn document(page: &Page) -> Value {
    let mut document = Map::new();
    let mut put = |key: &str, value: Value| _ = document.insert(key.to_string(), value);
    put("schema", json!(1));
    put("machine", json!(page.inputs.job.machine.name));
    put("program", json!(page.program));
    put("blocks", json!(page.ran.blocks));
    put("holes", json!(page.ran.holes));
    let worst: Vec<Value> = page.holes.worst().iter().map(hole).collect();
    put("worst_holes", json!(worst));
    let missing: Vec<String> = page.volume.missing().into_iter().map(|m| m.name).collect();
    put("outside", json!(outside_sentences(page)));
    put("missing", json!(missing));
    put("warnings", json!(warnings(page)));
    put("notes", json!(remarks(page)));
    let after = page.after.as_ref().map(|after| {
        let mut map = Map::new();
        map.insert("tables".to_string(), json!(after.from));
        map.extend(figures(&after.followed));
        map.insert("disagreements".to_string(), json!(after.disagreements));
        Value::Object(map)
    });
    put("after", json!(after));
    document.extend(figures(&page.before));
    Value::Object(document)
}

fn hole(hole: &Hole) -> Value {
    let um = |vector: [f64; 3]| json!(vector.map(picometres));
    json!({
        "hole": hole.number,
        "line": hole.line,
        "at_mm": hole.place,
        "error_um": um(hole.error_um),
        "e_um": picometres(length(hole.error_um)),
        "after_um": hole.after_um.map(um),
        "after_e_um": hole.after_um.map(|after| picometres(length(after))),
    })
}

fn figures(followed: &Followed) -> Map<String, Value> {
    let s = &followed.summary;
    let extreme = |e: &Extreme| json!({"um": picometres(e.um), "at_mm": e.place, "line": e.line});
    let mut ranges = Map::new();
    for channel in Channel::ALL {
        let range = s.range(channel);
        let key = if channel == Channel::Length {
            "e"
        } else {
            channel.name()
        };
        let value = range.map(|r| json!({"min": extreme(&r.min), "max": extreme(&r.max)}));
        ranges.insert(key.to_string(), json!(value));
    }
    let mut figures = Map::new();
    let mut put = |key: &str, value: Value| _ = figures.insert(key.to_string(), value);
    put("length_mm", json!(s.length_mm));
    put(
        "moves",
        json!({"straight": s.lines, "arcs": s.arcs, "rapid_left_out": s.rapids_left_out}),
    );
    put("extremes", Value::Object(ranges));
    let most = followed.accuracy_um + s.room_um;
    put(
        "profile_accuracy_um",
        json!(picometres(followed.accuracy_um)),
    );
    put("profile_accuracy_at_most_um", json!(picometres(most)));
    put("samples", json!(s.samples));
    figures
}
