"""Fleets: one function on pandas, Dask and in parts; what it says is what the program says of each machine."""

import json
import pathlib

import numpy as np
import pandas as pd
import pytest
from conftest import columns, job_of

import nonius
from nonius import fleet

YEARS = pd.to_datetime(["2023-01-01", "2024-01-01", "2025-01-01", "2026-01-01"])


@pytest.fixture
def machines(errors):
    """Three machines whose errors grow by different shares each year, in a row each visit."""
    growth = {"a": 0.05, "b": 0.0, "c": 0.2}
    shape = {name: list(errors[name]) for name in ("axis", "position_mm")}
    rows = [
        {"machine": machine, "date": date, **shape}
        | {name: errors[name] * (1 + share * year) for name in ("ex_um", "ey_um", "ez_um")}
        for machine, share in growth.items()
        for year, date in enumerate(YEARS)
    ]
    return pd.DataFrame(rows)


def test_a_visit_of_a_fleet_is_that_visit(machines, job, errors):
    results = fleet.judge(machines, job, limit_um=50)
    assert list(results.columns) == list(fleet.COLUMNS) and len(results) == 12
    first = results.iloc[0]
    alone = nonius.Visit(job | {"measurement": {**job["measurement"], "date": "2023-01-01"}}, errors=errors)
    assert first["verdict"] == alone.forecast().verdict == "pass" and "every term within 10 µm" in first["scope"]
    assert first["va_um"] == alone.assess("--grid", fleet.GRID).va_um == pytest.approx(36.85, abs=0.05)
    assert first["EXX_found_um"] == 18.0 and np.isnan(first["EXX_u95_um"]) and np.isnan(first["va_drift_um"])
    assert results.iloc[1]["EXX_drift_um"] == pytest.approx(0.9)
    assert results.iloc[1]["xy_drift_um_per_m"] == pytest.approx(0.05 * 19.166667)


def one(machines, **columns):
    """The visits of machine b, whose errors stay as they are, with other columns."""
    return machines[machines["machine"] == "b"].reset_index(drop=True).assign(**columns)


def test_the_day_of_service_follows_from_the_trend(machines, job):
    last = fleet.judge(machines, job, limit_um=50).groupby("machine").last()
    # VA of a is 36.85 µm and grows by 1.84 µm a year: 50 µm after 7.13 years; c is beyond it at its last visit.
    assert abs((last.loc["a", "due"] - pd.Timestamp("2023-01-01")).days - 7.133 * 365.25) < 12
    assert last.loc["a", "due_earliest"] <= last.loc["a", "due"] <= last.loc["a", "due_latest"]
    assert pd.isna(last.loc["b", "due"]) and last.loc["c", "due"] == YEARS[-1]
    assert fleet.judge(machines[:1], job, 30)["due"][0] == YEARS[0], "one visit beyond the limit is due"


def test_noise_widens_the_interval():
    visits = [{"date": date, "va_um": va} for date, va in zip(YEARS, [30.0, 32.5, 31.0, 34.0])]
    due = fleet._due(visits, 40.0)
    # By hand: slope 1.05 µm a year, 34.0 is 0.55 above the line at the last visit: (40 - 33.45) / 1.05 = 6.24 years on.
    assert abs((due["due"] - YEARS[-1]).days - 6.24 * 365.25) < 4
    # s = 1.356 µm, Student's k (95 %, 2) = 4.303: line + band meets 40 µm 188 days on.
    assert (due["due_earliest"] - YEARS[-1]).days == 188 and "due_latest" not in due


def test_a_turned_sign_is_a_drift(machines, job, errors):
    frame = one(machines)
    frame.at[1, "ex_um"] = -errors["ex_um"]
    results = fleet.judge(frame, job)
    assert results["EXX_drift_um"].tolist()[1:] == pytest.approx([-36.0, 36.0, 0.0])


def test_a_reversal_that_grew_is_a_drift(machines, job, errors):
    """Both directions have one zero, that of the reference return: the other carries the reversal (contract §2.3)."""
    frame = one(machines)[:3].astype({"ex_um": object})
    both = {name: np.tile(errors[name], 2) for name in ("axis", "position_mm", "ex_um", "ey_um", "ez_um")}
    both |= {"direction": np.repeat(["+", "-"], 93)}
    for visit, reversal in enumerate((-2.0, -30.0, -30.0)):
        is_back = (both["direction"] == "-") & (both["axis"] == "x")
        frame = frame.assign(direction=None) if visit == 0 else frame
        for name, values in (both | {"ex_um": both["ex_um"] + reversal * is_back}).items():
            frame.at[visit, name] = list(values)
    job["compensation"]["backlash"] = "two-tables"
    results = fleet.judge(frame, job)
    assert results["EXX_drift_um"].tolist()[1:] == pytest.approx([-28.0, 0.0])
    assert results["EYX_drift_um"].tolist()[1:] == pytest.approx([0.0, 0.0]) and set(results["problem"]) == {""}
    job["machine"]["axes"]["x"]["reference_direction"] = "-"
    assert fleet.judge(frame, job)["EXX_drift_um"][1] == pytest.approx(28.0)


def test_u_of_a_drift_is_that_of_its_two_visits(machines, job):
    u = [[1.0] * 93, None, [1.0] * 93, [0.5] * 93]
    results = fleet.judge(one(machines, u_ex_um=u), job)
    assert np.isnan(results["EXX_drift_u95_um"][:3]).all()
    assert results["EXX_drift_u95_um"][3] == pytest.approx(2 * np.sqrt(2 * 1 + 2 * 0.25))
    job["measurement"]["uncertainty"] = {"noise_um": 0.3}
    stated = fleet.judge(one(machines), job)
    assert stated["EYX_drift_u95_um"][1] == pytest.approx(2 * np.sqrt(4 * 0.3**2))


def test_units_of_a_table_are_those_of_the_program(machines, job):
    plain = one(machines)
    plain.at[1, "ex_um"] = plain.at[1, "ex_um"] * 1.5
    inches = [plain["position_mm"].map(lambda mm: np.array(mm) / 25.4), plain["ex_um"] / 25.4, plain["ey_um"] / 1000, plain["ez_um"]]
    names = ["position_in", "ex_uin", "ey_mm", "ez_um"]
    frame = plain[["machine", "date", "axis"]].assign(**dict(zip(names, inches)))
    frame["ex_uin"] = plain["ex_um"] / 0.0254
    found, expected = (fleet.judge(of, job, 50) for of in (frame, plain))
    assert expected["EXX_drift_um"][1] == pytest.approx(9.0) and expected["va_drift_um"][1] > 1
    pd.testing.assert_frame_equal(found, expected, rtol=1e-6, atol=1e-6)


def test_what_was_measured_otherwise_is_named_and_not_compared(machines, job):
    frame = one(machines)
    inner = np.array((frame.at[1, "axis"])) != "x"
    inner |= np.array(frame.at[1, "position_mm"]) < 500
    for name in ("axis", "position_mm", "ex_um", "ey_um", "ez_um"):
        frame.at[1, name] = list(np.array(frame.at[1, name])[inner])
    frame["direction"] = [None, None, None, ["+"] * 93]
    results = fleet.judge(frame, job)
    terms = ["EXX EYX EZX", "EXX EYX EZX", "EXX EYX EZX EXY EYY EZY EXZ EYZ EZZ"]
    assert results["not_compared"].tolist() == ["", f"VA {terms[0]}", f"VA {terms[1]}", terms[2]]
    assert results["EXX_drift_um"].isna().all() and results["EYY_drift_um"][1] == 0.0


def test_a_job_on_disk_finds_what_lies_beside_it(machines, job, tmp_path, monkeypatch):
    (tmp_path / "plant").mkdir()
    monkeypatch.chdir(tmp_path)
    angles = "axis,position_mm,ea_urad\nx,0,0\nx,900,%d\n"
    pathlib.Path("plant/angles.csv").write_text(angles % 50)
    pathlib.Path("angles.csv").write_text(angles % 5000)
    pathlib.Path("plant/job.toml").write_text(as_toml(job | {"measurement": {**job["measurement"], "angles": "angles.csv"}}))
    first = machines[:1]
    va_um = fleet.judge(first, "plant/job.toml")["va_um"][0]
    for path in (pathlib.Path("plant/job.toml"), tmp_path / "plant/job.toml", lambda name: "plant/job.toml"):
        assert fleet.judge(first, path)["va_um"][0] == va_um
    in_current = fleet.judge(first, job | {"measurement": {**job["measurement"], "angles": "angles.csv"}})
    assert in_current["va_um"][0] > 2 * va_um > 0
    assert fleet.judge(first, "plant/nowhere.toml")["problem"][0].startswith("FileNotFoundError")


def as_toml(sections, above=""):
    values = [f"{key} = {json.dumps(value)}\n" for key, value in sections.items() if not isinstance(value, dict)]
    tables = [(above + key, value) for key, value in sections.items() if isinstance(value, dict)]
    return "".join(values) + "".join(f"[{key}]\n" + as_toml(value, key + ".") for key, value in tables)


def test_tables_loaded_between_visits_begin_anew(machines, job):
    results = fleet.judge(one(machines, since=["", "", "2025", "2025"]), job, 50)
    assert np.isnan(results["va_drift_um"][2]) and results["va_drift_um"][3] == 0


def test_an_incomplete_visit_is_not_compared_as_if_it_were_whole(machines, job):
    frame = one(machines)
    frame.at[1, "ez_um"] = None
    results = fleet.judge(frame, job)
    assert "EZX" in results["missing"][1] and results["va_drift_um"].isna().tolist() == [True, True, True, False]
    assert np.isnan(results["EZX_found_um"][1]) and results["EXX_drift_um"][1] == 0


@pytest.mark.parametrize("date", [20230101, None, "03.04.2024", "soon", pd.NaT])
def test_what_is_no_date_costs_its_own_row(machines, job, date):
    frame = one(machines).astype({"date": object})
    frame.at[0, "date"] = date
    results = fleet.judge(frame, job)
    assert (results["problem"] != "").sum() == 1 and results["va_drift_um"].notna().sum() == 2


def test_dates_of_every_kind_are_days(machines, job):
    dates = ["2023-01-01", pd.Timestamp("2024-01-01 23:30", tz="Asia/Tokyo"), np.datetime64("2025-01-01"), YEARS[3].date()]
    assert fleet.judge(one(machines, date=pd.Series(dates, dtype=object)), job)["date"].tolist() == YEARS.tolist()


def test_a_machine_that_cannot_be_judged_costs_its_own_row(machines, job):
    machines.at[5, "ex_um"] = [np.nan, *machines.at[5, "ex_um"][1:]]
    machines.at[0, "ey_um"] = "0;1;2"
    results = fleet.judge(machines, lambda name: job if name != "c" else {}["no job"])
    assert (results["problem"] != "").sum() == 2 + 4 and "is empty in one row of axis X" in results.loc[5, "problem"]
    assert "the column `ey_um` is no list" in results.loc[0, "problem"]
    assert results.loc[6, "va_drift_um"] == 0.0, "the drift is that since the last visit that could be judged"


@pytest.mark.parametrize("bad", [None, [], {}, {"machine": {"axes": []}}, {"measurement": None}, "nowhere.toml", 1 / 3])
def test_no_job_of_one_machine_costs_another_its_row(machines, job, bad):
    results = fleet.judge(machines[3:5], lambda name: job if name == "a" else bad)
    assert results["verdict"].tolist() == ["pass", ""] and results["problem"][1]


def test_numbers_of_every_kind_are_read_and_infinite_ones_told(machines, job, errors):
    frame = one(machines, ex_um=[errors["ex_um"].astype(np.longdouble), errors["ex_um"], np.append(np.inf, errors["ex_um"][1:]), errors["ex_um"]])
    results = fleet.judge(frame, job)
    assert results["EXX_found_um"].tolist()[:2] == [18.0, 18.0] and "errors.csv:2" in results["problem"][2]
    assert (results["problem"] != "").sum() == 1 and "`ex_um` is `inf`" in results["problem"][2]


def test_readings_are_compared_as_their_errors():
    table = {name: list(values) for name, values in columns("start/readings/readings.csv").items()}
    frame = pd.DataFrame([{"machine": "a", "date": date, **table} for date in YEARS[:2]])
    results = fleet.judge(frame, job_of("start/readings/job.toml"))
    assert set(results["problem"]) == {""} and results["EXX_drift_um"][1] == results["va_drift_um"][1] == 0.0
    assert results["EXX_drift_u95_um"][1] > 1 and set(results["not_compared"]) == {""}


def test_remarks_of_a_table_reach_the_verdict(machines, job):
    results = fleet.judge(one(machines, remarks=[["doubt: a loose mirror"]] * 4), job)
    assert set(results["verdict"]) == {"undecided"}


def test_one_frame_in_parts_and_packed_is_the_same(machines, job):
    whole = fleet.judge(machines, job, 50)
    parts = [machines[:3], machines[3:4], machines[4:11], machines[11:]]
    pd.testing.assert_frame_equal(pd.concat(fleet.judge_parts(parts, job, 50), ignore_index=True), whole)
    values = machines.explode([name for name in machines if name not in ("machine", "date")])
    pd.testing.assert_frame_equal(fleet.judge(fleet.packed(values), job, 50), whole)
    assert len(fleet.judge(machines[:0], job)) == 0
    with pytest.raises(ValueError, match="do not lie together"):
        list(fleet.judge_parts([machines[:2], machines[4:6], machines[2:4]], job))


def test_dask_says_the_same(machines, job, tmp_path):
    dask = pytest.importorskip("dask")
    frames = pytest.importorskip("dask.dataframe")
    machines.to_parquet(tmp_path / "fleet.parquet", row_group_size=4)
    with dask.config.set({"dataframe.convert-string": False}):
        read = frames.read_parquet(tmp_path / "fleet.parquet", split_row_groups=True)
        assert read.npartitions == 3
        found = read.map_partitions(fleet.judge, job, limit_um=50, meta=fleet.META).compute(scheduler="processes", num_workers=2)
    pd.testing.assert_frame_equal(found.reset_index(drop=True), fleet.judge(machines, job, 50))


def test_the_page_of_a_fleet(machines, job):
    machines.at[5, "ex_um"] = [np.nan, *machines.at[5, "ex_um"][1:]]
    page = fleet.report(fleet.judge(machines, job, 50), "Plant <2>", 50)
    assert "Plant &lt;2&gt;" in page and "<script" not in page and "http" not in page.replace("http://www.w3.org/2000/svg", "")
    assert page.count("<svg") == 1 and "3 machines, 12 visits, 2023-01-01 to 2026-01-01" in page
    assert "is empty in one row" in page and "2026-01-01" in page
