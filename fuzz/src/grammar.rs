//! What a line of a control's file may look like, written from the formats' descriptions (docs/siemens.md §3.2,
//! docs/fanuc.md §3.2, docs/interface.md §4.1, docs/linuxcnc.md §2, docs/isg.md §3). It knows nothing of templates, of `src/write/emit` or of `src/read`.

use nonius::control::controller::Dialect;

/// What is wrong with a file that a control loads.
pub(crate) fn judge(family: &Dialect, name: &str, bytes: &[u8]) -> Result<(), String> {
    let mut bytes = bytes.to_vec();
    if matches!(family, Dialect::Declared(_)) {
        bytes.retain(|byte| *byte != 0); // the high bytes of UTF-16
    }
    let text = std::str::from_utf8(&bytes).map_err(|_| format!("{name} is not text"))?;
    if !text.is_ascii() {
        return Err(format!("{name} holds a letter that is not ASCII"));
    }
    let wrong = match family {
        Dialect::Siemens(_) => siemens(text),
        Dialect::Fanuc(_) => fanuc(text),
        Dialect::Linuxcnc(_) if name.ends_with(".ini") => ini(text),
        Dialect::Linuxcnc(_) if name.ends_with(".hal") => hal(text),
        Dialect::Linuxcnc(_) => comp(text),
        Dialect::Isg(_) if name.ends_with(".lis") => list(text),
        Dialect::Isg(_) => parameters(text),
        Dialect::Declared(facts) if facts.factors.is_some() => skew(text),
        Dialect::Declared(facts) if facts.typed.is_some() => match name {
            _ if name.ends_with(".json") => json(text),
            "typed.csv" => typed(text),
            _ => csv(text),
        },
        Dialect::Declared(_) => declared(text),
    };
    wrong.map_err(|line| format!("{name}: foreign line {line:?}"))
}

type Wrong = Result<(), String>;

fn siemens(text: &str) -> Wrong {
    let mut set = Vec::new();
    let mut ended = false;
    for (index, line) in text.lines().enumerate() {
        let is_head = index < 2
            && (line.starts_with("%_N_") && line.ends_with("_INI") || line == "CHANDATA(1)");
        let is_end = matches!(line, "M30" | "M17");
        let comment = line.starts_with(';') && !line.contains(|c: char| c.is_control());
        let variable = assignment(line);
        let known = is_head || is_end || comment || line == "NEWCONF" || variable.is_some();
        if ended || !known || variable.is_some_and(|variable| set.contains(&variable)) {
            return Err(line.to_string());
        }
        ended |= is_end;
        set.extend(variable);
    }
    if ended { Ok(()) } else { Err("no M30 or M17 at the end".to_string()) }
}

/// Words and numbers of any layout, and no number that is none.
fn declared(text: &str) -> Wrong {
    let is_none = |word: &str| {
        let word = word.trim_start_matches('-').to_ascii_lowercase();
        matches!(word.as_str(), "nan" | "inf" | "infinity" | "none" | "null")
    };
    let is_plain = |line: &&str| {
        let mut words = line.split([' ', ',', '=', '[', ']']);
        !line.contains("{{") && !line.chars().any(char::is_control) && !words.any(is_none)
    };
    let is_comment = |line: &&str| line.starts_with([';', '#']);
    let mut lines = text.lines().filter(|line| !is_comment(line));
    match lines.find(|line| !is_plain(line)) {
        Some(line) => Err(line.to_string()),
        None => Ok(()),
    }
}

/// Comments, and keys with their values, each once.
fn list(text: &str) -> Wrong {
    let mut seen = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (key, value) = line.split_once(' ').unwrap_or((line, ""));
        let is_right = match key {
            "X" | "Y" | "Z" => value.parse::<u16>().is_ok(),
            "chain" => value.len() == 3 && ["X", "Y", "Z"].iter().all(|axis| value.contains(axis)),
            "workpiece_axes" | "alternative_model" => value == "0",
            "interpolation" => value == "GRID",
            "file[0]" => value.ends_with("volcomp.csv"),
            "file_format[0]" => value == "ISG_CSV",
            _ => false,
        };
        if !is_right || seen.contains(&key) {
            return Err(line.to_string());
        }
        seen.push(key);
    }
    Ok(())
}

/// Comments, two sections and three factors, each once.
fn skew(text: &str) -> Wrong {
    let mut seen = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
        let is_right = match line.split_once(" = ") {
            Some(("xy_skew" | "xz_skew" | "yz_skew", value)) => is_number(value),
            _ => line.starts_with("[skew_correction"),
        };
        let key = line.split(" = ").next().unwrap_or(line);
        if !is_right || seen.contains(&key) {
            return Err(line.to_string());
        }
        seen.push(key);
    }
    Ok(())
}

/// Comments, headers of parameters and rows of as many numbers, `#` behind each block.
fn parameters(text: &str) -> Wrong {
    let mut columns = 0;
    for line in text.lines().filter(|line| !line.starts_with("//")) {
        let words: Vec<&str> = line.split(' ').collect();
        let is_name = |word: &&str| word.len() == 3 && word.starts_with('E');
        let is_header = columns == 0 && matches!(words[0], "X" | "Y" | "Z");
        let is_right = match line {
            "#" => columns > 1,
            _ if is_header => words[1..].iter().all(is_name),
            _ => words.len() == columns && words.iter().all(|word| is_number(word)),
        };
        if !is_right {
            return Err(line.to_string());
        }
        columns = match line {
            "#" => 0,
            _ => words.len(),
        };
    }
    match columns {
        0 => Ok(()),
        _ => Err("no # at the end".to_string()),
    }
}

/// Rows of three numbers, ascending, and nothing else.
fn comp(text: &str) -> Wrong {
    let mut before = f64::NEG_INFINITY;
    for line in text.lines() {
        let numbers: Vec<&str> = line.split(' ').collect();
        let nominal = numbers[0].parse().unwrap_or(f64::NEG_INFINITY);
        let is_row = numbers.len() == 3 && numbers.iter().all(|number| is_number(number));
        if !is_row || nominal <= before || line.len() > 253 {
            return Err(line.to_string());
        }
        before = nominal;
    }
    match text.lines().count() {
        2..=256 => Ok(()),
        rows => Err(format!("{rows} rows")),
    }
}

/// Comments, and of each joint its section with two settings, once.
fn ini(text: &str) -> Wrong {
    let mut seen = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let is_next = match line.split_once(" = ") {
            Some(("COMP_FILE", name)) => name.ends_with(".comp"),
            Some(("COMP_FILE_TYPE", number)) => matches!(number, "0" | "1"),
            _ => line.starts_with("[JOINT_") && line.ends_with(']') && !seen.contains(&line),
        };
        if !is_next {
            return Err(line.to_string());
        }
        seen.extend(line.starts_with('[').then_some(line));
    }
    Ok(())
}

/// Comments, and statements of which each stands once.
fn hal(text: &str) -> Wrong {
    let mut seen = std::collections::BTreeSet::new();
    let of_component = |name: &str| name.starts_with("lincurve.") || name.starts_with("sum2.");
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let words: Vec<&str> = line.split(' ').collect();
        let is_statement = match words[..] {
            ["loadrt", "lincurve", count, lengths] => {
                count.starts_with("count=") && lengths.starts_with("personality=")
            }
            ["loadrt", "sum2", count] => count.starts_with("count="),
            ["addf", function, "servo-thread"] => of_component(function),
            ["net", signal, pin] => {
                signal.starts_with("nonius-") && (of_component(pin) || pin.starts_with("joint."))
            }
            ["setp", name, value] => of_component(name) && value.parse::<f64>().is_ok(),
            _ => false,
        };
        if !is_statement || !seen.insert(line) {
            return Err(line.to_string());
        }
    }
    Ok(())
}

/// The variable of `[N12345 ]$NAME[index,…]=value[ ; value]`.
fn assignment(line: &str) -> Option<&str> {
    let numbered =
        line.strip_prefix('N').map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    let line = numbered.map_or(line, str::trim_start);
    let (variable, value) = line.split_once('=')?;
    let (value, comment) = value.split_once(" ; ").unwrap_or((value, "0"));
    let (name, indices) = variable.strip_prefix('$')?.strip_suffix(']')?.split_once('[')?;
    let indices: Vec<&str> = indices.split(',').collect();
    let shape: Vec<bool> = indices.iter().map(|index| is_whole(index)).collect();
    let shape_fits = match name {
        "AA_ENC_COMP" => matches!(shape[..], [true, true, false]),
        "AN_CEC" => shape == [true, true],
        "AA_ENC_COMP_STEP"
        | "AA_ENC_COMP_MIN"
        | "AA_ENC_COMP_MAX"
        | "AA_ENC_COMP_IS_MODULO"
        | "MA_ENC_COMP_ENABLE"
        | "MA_MM_ENC_COMP_MAX_POINTS" => shape == [true, false],
        "MA_CEC_ENABLE" | "MA_BACKLASH" | "MA_CEC_MAX_SUM" => shape[0] == (name == "MA_BACKLASH"),
        "AN_CEC_STEP"
        | "AN_CEC_MIN"
        | "AN_CEC_MAX"
        | "AN_CEC_DIRECTION"
        | "AN_CEC_MULT_BY_TABLE"
        | "AN_CEC_IS_MODULO"
        | "AN_CEC_INPUT_AXIS"
        | "AN_CEC_OUTPUT_AXIS"
        | "SN_CEC_TABLE_ENABLE"
        | "MN_MM_CEC_MAX_POINTS" => shape == [true],
        _ => false,
    };
    let names_fit = indices.iter().all(|index| is_whole(index) || is_name(index));
    let value_fits = match name.ends_with("PUT_AXIS") {
        true => value.strip_prefix('(').and_then(|v| v.strip_suffix(')')).is_some_and(is_name),
        false => is_number(value),
    };
    (shape_fits && names_fit && value_fits && is_number(comment)).then_some(variable)
}

fn fanuc(text: &str) -> Wrong {
    let lines: Vec<&str> = text.split('\n').map(|line| line.trim_matches('\r')).collect();
    let Some((["%", inside @ ..], ["%", ""])) =
        lines.len().checked_sub(2).map(|at| lines.split_at(at))
    else {
        return Err("no % at the beginning and at the end".to_string());
    };
    let mut set = Vec::new();
    for line in inside {
        let words = record(line).ok_or_else(|| line.to_string())?;
        if words.iter().any(|word| set.contains(word)) {
            return Err(format!("{line} (again)"));
        }
        set.extend(words);
    }
    Ok(())
}

/// Number and axis of what `N00000Q1A1P0A2P0`, `N00000Q1L1P0` (of a path), `N00000Q0P0` or `N0000A1P0` sets.
fn record(line: &str) -> Option<Vec<(&str, &str)>> {
    let rest = line.strip_prefix('N')?;
    let (number, values) = rest.split_at(rest.find(|c: char| !c.is_ascii_digit())?);
    // The 16i knows no Q.
    let values = values.strip_prefix("Q0").or(values.strip_prefix("Q1")).unwrap_or(values);
    let values = values.strip_prefix("L1").unwrap_or(values);
    if !(4..=5).contains(&number.len()) {
        return None;
    }
    if let Some(value) = values.strip_prefix('P') {
        return is_number(value).then(|| vec![(number, "")]);
    }
    let axes = values.strip_prefix('A')?.split('A').map(|axis| axis.split_once('P'));
    axes.map(|pair| {
        pair.filter(|(axis, value)| is_whole(axis) && is_number(value))
            .map(|(axis, _)| (number, axis))
    })
    .collect()
}

fn csv(text: &str) -> Wrong {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let head = "term,base_axis,output_axis,direction,index,position_mm,deviation_um,correction_um,increment_um";
    if lines.next() != Some(head) {
        return Err("another header".to_string());
    }
    let is_row = |line: &&str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [term, base, output, direction, index, position, deviation, correction, increment] =
            cells[..]
        else {
            return false;
        };
        let numbers = [position, deviation, correction].iter().all(|cell| is_figure(cell));
        let words = is_name(term)
            && is_name(base)
            && is_name(output)
            && ["", "+", "-"].contains(&direction);
        numbers && words && is_whole(index) && (increment.is_empty() || is_figure(increment))
    };
    lines.find(|line| !is_row(line)).map_or(Ok(()), |line| Err(line.to_string()))
}

/// Points of tables on pages, each page with its sum; the values in one unit, the column `seen` empty.
fn typed(text: &str) -> Wrong {
    let (head, rows) = text.split_once('\n').unwrap_or_default();
    let value = head
        .strip_prefix("term,base_axis,output_axis,direction,zero_mm,page,point,position_mm,")
        .and_then(|rest| rest.strip_suffix(",seen"));
    let (kind, unit) = value.and_then(|value| value.rsplit_once('_')).unwrap_or_default();
    let is_kind = ["deviation", "correction", "increment", "outward_increment"].contains(&kind);
    if !is_kind || !["um", "mm", "inch", "count"].contains(&unit) {
        return Err(head.to_string());
    }
    let is_row = |line: &&str| {
        let cells: Vec<&str> = line.split(',').collect();
        let [term, base, output, direction, zero, page, point, position, value, ""] = cells[..]
        else {
            return false;
        };
        let place = match point {
            "sum" => zero.is_empty() && position.is_empty(),
            _ => is_whole(point) && is_number(zero) && is_number(position),
        };
        let names = [term, base, output].into_iter().all(is_name);
        names && ["", "+", "-"].contains(&direction) && is_whole(page) && place && is_number(value)
    };
    let foreign = rows.lines().find(|line| !is_row(line));
    foreign.map_or(Ok(()), |line| Err(line.to_string()))
}

fn json(text: &str) -> Wrong {
    let Some(rows) = text
        .strip_prefix("{\"schema\":1,\"rows\":[\n")
        .and_then(|rest| rest.strip_suffix("\n]}\n"))
    else {
        return Err("another frame".to_string());
    };
    let is_pair = |pair: &str| {
        let Some((key, value)) = pair.split_once(':') else {
            return false;
        };
        let quoted = |text: &str| {
            text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).map(str::to_string)
        };
        let word =
            quoted(value).is_some_and(|word| is_name(&word) || ["+", "-"].contains(&word.as_str()));
        quoted(key).is_some_and(|key| is_name(&key))
            && (word || value == "null" || is_figure(value))
    };
    let is_row = |row: &&str| {
        let inside =
            row.trim_end_matches(',').strip_prefix('{').and_then(|row| row.strip_suffix('}'));
        inside.is_some_and(|row| row.split(',').count() == 9 && row.split(',').all(is_pair))
    };
    rows.lines().find(|row| !is_row(row)).map_or(Ok(()), |row| Err(row.to_string()))
}

fn is_whole(text: &str) -> bool {
    (1..=6).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit())
}

fn is_name(text: &str) -> bool {
    let letter = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.bytes().all(letter)
}

/// A number, also with an exponent, as only the generic tables have it.
fn is_figure(text: &str) -> bool {
    let (digits, exponent) = text.split_once('e').unwrap_or((text, "0"));
    is_number(digits) && is_whole(exponent.strip_prefix('-').unwrap_or(exponent))
}

/// Digits with at most one point between them; zero has no sign.
fn is_number(text: &str) -> bool {
    let size = text.strip_prefix('-').unwrap_or(text);
    let (whole, part) = size.split_once('.').unwrap_or((size, "0"));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_zero = size.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    digits(whole) && digits(part) && !(is_zero && text.starts_with('-'))
}

#[cfg(test)]
mod tests {
    use super::judge;
    use nonius::control::controller::builtin;

    #[test]
    fn a_foreign_line_is_found_in_every_family() {
        let files = [
            (
                "siemens-840d-sl",
                "a.MPF",
                "; A\n$AN_CEC[0,1]=0.002000 ; 100.000000\n$AN_CEC_INPUT_AXIS[0]=(AX1)\nM30\n",
            ),
            ("fanuc-30i", "a.TXT", "%\nN03620Q1A1P0A2P12\nN10001Q0P-2\n%\n"),
            (
                "generic",
                "a.json",
                "{\"schema\":1,\"rows\":[\n{\"term\":\"EXX\",\"base_axis\":\"x\",\"output_axis\":\"x\",\"direction\":null,\"index\":0,\"position_mm\":0,\"deviation_um\":0,\"correction_um\":0,\"increment_um\":null}\n]}\n",
            ),
            (
                "generic",
                "typed.csv",
                "term,base_axis,output_axis,direction,zero_mm,page,point,position_mm,correction_um,seen\nEYY,y,y,,0,4,0,-200,-4,\nEYY,y,y,+,,4,sum,,-4,\n",
            ),
            ("linuxcnc", "a.comp", "0.000000 0.000000 0.000000\n100.000000 -0.002000 0.001000\n"),
            ("linuxcnc", "a.ini", "# A\n[JOINT_0]\nCOMP_FILE = a.comp\nCOMP_FILE_TYPE = 1\n"),
            ("isg-volcomp", "a.lis", "# A\nX 1\nchain XYZ\nfile[0] volcomp.csv\n"),
            ("isg-volcomp", "a.csv", "// A\nX EXX EAX\n0.000000 0.000000 0.000000000\n#\n"),
            (
                "linuxcnc",
                "a.hal",
                "# A\nloadrt sum2 count=1\nnet nonius-0-drive sum2.0.out\nsetp sum2.0.gain1 -1\n",
            ),
        ];
        for (id, name, text) in files {
            let family = &builtin::profile(id).unwrap().dialect;
            assert_eq!(judge(family, name, text.as_bytes()), Ok(()));
            for foreign in
                ["G0 X0\n", "$AN_CEC[0,1]=1\n", "N10001Q0P3\n", "M30\n", "ä\n", "$AN_CEC[0,2]=-0\n"]
            {
                let place = text.find('\n').map_or(0, |end| end + 1);
                let mut other = text.to_string();
                other.insert_str(place, foreign);
                assert!(judge(family, name, other.as_bytes()).is_err(), "{other}");
            }
        }
    }
}
