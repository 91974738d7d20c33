//! Whole files of a machine of five points an axis: a snapshot was checked by hand when it was accepted.
use crate::support::{self, five_points, in_repository};
use nonius::control::controller::{Role, builtin};
use nonius::kit::Kit;

fn kit(profile: &str) -> Kit {
    let (job, errors) = five_points(profile);
    support::generate(&job.replace('\r', ""), &errors.replace('\r', "")).1
}

/// Control characters made visible; the line end of a file stays a line end.
fn visible(bytes: &[u8]) -> String {
    let units = bytes.chunks_exact(2).map(|two| u16::from_le_bytes([two[0], two[1]]));
    let text = match bytes.contains(&0) {
        false => String::from_utf8(bytes.to_vec()).unwrap(),
        true => format!("UTF-16LE\n{}", String::from_utf16(&units.collect::<Vec<_>>()).unwrap()),
    };
    text.replace("\n\r\r", "␊␍␍¶").replace("\r\n", "␍␊¶").replace('\r', "␍").replace('¶', "\n")
}

/// How a person checks a file with the error table beside it: the beginnings of the ids, the role of
/// the file or the end of its name, what stands there. The first that fits counts; `*` fits always.
const BY_HAND: &str = "\
* checklist: places, preconditions and bumps as in the other files; a movement is the largest
  correction of each moving axis added up
linuxcnc .hal: joint i gets minus the deviation of errors.csv of the other joints' positions, less
  that at their references, mean of both directions (X at 200 mm: -0.002 for Y); each sum is added
  to the command and taken out of the encoder; the sign proof has one bump of -0.020
linuxcnc sign-proof: the rows of the kit, zero but for -0.020 mm in both columns of X at 200 mm
  (the axis is pulled back by 20 um); the ini names these files
linuxcnc parameters: each table of the kit in the section of its joint, type 1
linuxcnc *: position, value to add moving up, value to add moving down, in mm: minus the deviation
  of errors.csv, less that at the reference (X+ at 400 mm 8 um = -0.008, X- at 0 mm 3 um = -0.003)
isg-axis sign-proof: 0.1 um: a table of an axis for itself has one bump of 200 (as_error), or one
  that follows another axis one of -200 (as_correction); the other tables of that kind are zero
isg-axis *: 0.1 um: ssfk as in errors.csv less that at the reference (pos of axis 1 at 400 mm 8 um
  = 80, neg 11 um = 110); crosscomp minus the mean of both directions, one master for each axis
fagor,heidenhain sign-proof: the tables of the kit, zero but for 0.0200 mm in both columns of one
  point (as_error)
fagor,heidenhain *: the deviation of errors.csv less that at the reference, mm: Fagor moving in +
  and then in -, HEIDENHAIN moving in - (BACKLASH) and then in + (X at 400 mm + 0.0080, - 0.0110)
aerotech sign-proof: the tables of the kit, zero but for one value of -0.020 mm (as_correction:
  the axis is pulled back by 20 um)
aerotech *: HOMEOFFSET is the first point; values are minus the mean of both directions of
  errors.csv less that at the reference, mm (X at 400 mm 9.5 less 1.5 um = -0.008)
weihong sign-proof: the tables of the kit, zero but for +0.020 mm in both columns of one point
  (as_error: the axis is pulled back by 20 um)
weihong *: position, deviation moving in +, deviation moving in -, in mm: as in errors.csv less
  that at the reference (X+ at 400 mm 8 um = 0.008, X- at 0 mm 3 um = 0.003)
klipper sign-proof: one factor: 20 um at the end of the travel, in mm in a mm
klipper *: slopes of errors.csv between the ends in mm in a mm: EXY (2 + 2) um in 400 mm =
  0.000010, EXZ (0 - 4) um in 400 mm = -0.000010, EYZ (0 - 1) um in 400 mm = -0.0000025
isg parameters: logical axis numbers, chain from the workpiece to the tool, one parameter file
isg sign-proof: the parameters of the kit, zero but for one value of 0.020 mm; the list names this
  file
isg *: deviation of errors.csv in mm less that at the reference, of X the mean of both directions
  (at 400 mm (8 + 8) / 2 = 8 um = 0.008); no angle was measured, and no C0Y is written: squareness
  stands in the slopes
siemens sign-proof: the tables of the kit, zero but for one value of 0.020 = 20 um (100 mm at 1
  um/mm would allow more), at least one section away from the reference, zero at both ends
fanuc sign-proof: the points of the kit, zero but for -7 in one section and 7 in the next (seven
  counts of 1 um is the largest increment; as_correction: the axis is pulled back); a second run
  of X has the same; four points: amounts 0 -7 0 0
siemens table: a value is the deviation of errors.csv in mm less that at the reference (as_error):
  X+ at 400 mm 8 um = 0.008, X- at 0 mm 3 um = 0.003 (two CEC tables, DIRECTION 1 and -1); Y at
  200 mm -6 um = -0.006; MIN + index * STEP is the position
siemens parameters: five points for every table of the other files
siemens *: every ENC_COMP table, every CEC table and every output axis of a CEC table once
fanuc parameters: 3620 is the point of the reference, 3621 and 3622 first and last point, 3623 =
  1, 3624 the spacing 100 mm; 3627 of axis 1 is -3: the correction of the 3 um that X- has at the
  reference. Y (axis 2) has two sections on each side of its reference, Z (axis 3) has all below
  it. Sets: 5711 moving axis, 5721 axis it shifts
fanuc *: a point is the change of the correction (minus the deviation, in um) over its section,
  seen from - to +: X 0 2 4 6 8 um gives -2 in every section after the reference point; Y 4 2 0 -3
  -6 um gives 2 2 3 3; Z 8 6 4 2 0 um gives 2 2 2 2
mitsubishi typed.csv: twice the change of the correction in um over the section towards the reference,
  0 there: X 0 2 4 um gives -4; Y 4 2 0 -3 um gives 4 4 0 6; Z 4 2 0 um gives 4 4 0
haas typed.csv: minus the mean of both directions of errors.csv less that at the reference, in
  0.0001 in of 2.54 um: X 2 4 6 8 um gives -1 -2 -2 -3; Y -6 um gives 2
centroid typed.csv: minus the deviation of errors.csv less that at the reference of X+, in counts of 1 um
  (X+ at 400 mm -8, X- at 0 mm -3)
* *: deviation as in errors.csv, less that at the reference; correction is minus the deviation;
  increment is the change of the correction from the row before
";

fn by_hand(profile: &str, path: &str, role: Role) -> String {
    let text = BY_HAND.replace("\n  ", " ");
    let fits = |line: &&str| {
        let (ids, what) = line.split_once(": ").unwrap().0.split_once(' ').unwrap();
        let is_id = ids.split(',').any(|id| id == "*" || profile.starts_with(id));
        is_id && (what == "*" || what == role.word() || path.ends_with(what))
    };
    let line = text.lines().find(fits).unwrap();
    line.split_once(": ").unwrap().1.to_string()
}

/// Compares with the snapshot of a name, which says how it was checked by hand.
fn is_as_checked(name: &str, checked: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_description(checked);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

/// A file without a snapshot differs too. All that differ are named at the end.
#[test]
fn every_file_of_every_profile_is_as_it_was_checked() {
    let mut differ = Vec::new();
    for profile in builtin::ids() {
        let mut files = kit(profile).files;
        // The printed checklist holds what the other one holds (tests/it/field_kit.rs): one shows its layout.
        files.retain(|file| file.path != "checklist.html" || profile == "generic");
        for file in &files {
            let name = format!("{profile}-{}", file.path);
            let checked = by_hand(profile, &file.path, file.role);
            let compare = || is_as_checked(&name, &checked, &visible(&file.bytes));
            if std::panic::catch_unwind(compare).is_err() {
                differ.push(name);
            }
        }
    }
    assert!(differ.is_empty(), "{differ:#?}");
}

#[test]
fn manifest() {
    let bytes = kit("fanuc-0i-f").manifest_bytes().unwrap();
    let checked = "before_um: largest deviation of errors.csv relative to the reference (EXX: \
        X- at 400 mm, 11 um). Three of six cross terms have a straightness set, the others are \
        listed as omitted";
    is_as_checked("fanuc-0i-f-manifest.json", checked, &visible(&bytes));
}

#[test]
fn list_of_controllers() {
    let listed = in_repository("controllers list").ends(0).out;
    let checked = "facts = manual + assumed + executed in every row";
    is_as_checked("controllers-list", checked, &listed);
}
