"""A visit from Python is the program's own: the same bytes, figures and problems."""

import copy
import pickle
import threading
import time

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from conftest import FIXTURES, columns, job_of

import nonius


def test_a_kit_is_that_of_the_program(tmp_path):
    path = FIXTURES / "nine_errors_900/siemens-840d-sl.toml"
    kit = nonius.Visit(path).generate()
    assert kit.keeps_acceptance and "NONIUS_CEC.MPF" in kit.files
    # What the program's own tests hold as golden, read here by code of another language.
    cec = kit.files["NONIUS_CEC.MPF"].decode()
    assert "$AN_CEC[0,1]=-0.000122" in cec.replace(" ", "")
    saved = kit.save(tmp_path / "kit")
    assert {file.name for file in saved.iterdir()} == set(kit.files)
    assert nonius.Visit(path).verify(saved).verdict == "pass"
    (saved / "NONIUS_CEC.MPF").write_text(cec.replace("-0.000122", "0.000122"))
    assert nonius.Visit(path).verify(saved).verdict == "fail"
    with pytest.raises(FileExistsError):
        kit.save(tmp_path / "kit")


@pytest.mark.parametrize("form", [dict, pd.DataFrame, pa.table, lambda table: pd.DataFrame(table).to_records(index=False)])
def test_tables_of_every_kind_are_one(job, errors, form):
    as_arrays = nonius.Visit(job, errors=errors).generate()
    assert nonius.Visit(job, errors=form(errors)).generate().files == as_arrays.files
    assert as_arrays.verify().terms.array("forecast_um").shape == (9,)


def test_the_forecast_is_that_of_the_kit(job, errors):
    visit = nonius.Visit(job, errors=errors)
    alone, read_back = visit.forecast(), visit.generate().verify()
    assert alone.document == read_back.document
    assert alone.terms["EXX"]["before_um"] == 18.0
    assert alone.squareness["xy"]["before_um_per_m"] == pytest.approx(19.166667)
    assert list(alone.to_pandas().index) == ["EXX", "EYX", "EZX", "EXY", "EYY", "EZY", "EXZ", "EYZ", "EZZ"]


def test_readings_become_errors_and_a_second_measurement_is_judged():
    job = job_of("diagonals/case_d_bidirectional/job.toml")
    del job["measurement"]["readings"]
    visit = nonius.Visit(job, readings=columns("diagonals/case_d_bidirectional/readings.csv"))
    found = visit.separate(trials=200)
    truth = columns("diagonals/case_d_bidirectional/truth.csv")
    assert found.errors["ex_um"].dtype == float and len(found.errors["axis"]) >= 33
    assert found.squareness_um_per_m["xy"] == pytest.approx(19.17, abs=0.5)
    of_files = nonius.Visit(FIXTURES / "diagonals/case_d_bidirectional/job.toml").separate(trials=200)
    assert all(np.array_equal(of_files.errors[name], column) for name, column in found.errors.items())
    # What the errors rest on comes along: without it a verdict would be better than it is.
    job["compensation"]["backlash"] = "mean"
    of_readings = nonius.Visit(job, readings=visit.readings).forecast()
    assert of_readings.verdict == "undecided"
    del job["measurement"]["step_diagonal"]
    for table in (found.errors, found.to_pandas()):
        assert nonius.Visit(job, errors=table).forecast().verdict == "undecided"
    assert set(truth) >= {"axis", "position_mm", "ex_um"}


def test_a_second_measurement_is_judged(job, errors):
    visit = nonius.Visit(job, errors=errors)
    kit = visit.generate()
    left = {name: column if name in ("axis", "position_mm") else column * 0.1 for name, column in errors.items()}
    as_left = kit.verify(after=left)
    assert as_left.verdict == "pass" and as_left.terms["EXX"]["after_um"] == pytest.approx(1.8)
    assert kit.verify(after=errors).verdict != "pass"
    assert "<html" in visit.report(kit, left)
    assert "iframe" in kit._repr_html_() and "sandbox" in as_left._repr_html_()


def test_a_second_visit_given_as_a_job_finds_the_kit_in_the_current_folder(tmp_path, monkeypatch):
    """Its files have the names of those of the first visit, and are others."""
    start = FIXTURES / "start/readings"
    monkeypatch.chdir(tmp_path)
    first = nonius.Visit(job_of("start/readings/job.toml"), readings=start / "readings.csv")
    kit = first.generate()
    kit.save("kit")
    after = nonius.Visit(job_of("start/readings/after.toml"), readings=start / "after.csv")
    of_files = nonius.Visit(start / "job.toml").verify("kit", after=after)
    assert kit.verify(after=after).verdict == "pass" and of_files.terms.array("after_um") == pytest.approx(kit.verify(after).terms.array("after_um"))
    assert kit.verify(after).terms["EXX"]["after_um"] == pytest.approx(0.713, abs=1e-3)


def test_a_missing_value_is_missing(job, errors):
    holed = copy.deepcopy(errors)
    holed["ex_um"][3] = np.nan
    with pytest.raises(nonius.Problem) as caught:
        nonius.Visit(job, errors=holed).generate()
    problem = caught.value
    assert (problem.file, problem.line) == ("errors.csv", 5)
    assert "is empty in one row of axis X" in problem.message and "measure it" in problem.help
    assert "5 |" in str(problem)


@pytest.mark.parametrize("cells", [lambda um: pd.array(um, dtype="Float64"), lambda um: [np.float32(x) for x in um], lambda um: pa.array(um)])
def test_cells_of_every_kind_are_read(job, errors, cells):
    """Masked, single, Arrow; missing in one cell is a problem of that cell, never a value or a failure of Python."""
    table = errors | {"ex_um": cells(errors["ex_um"])}
    assert nonius.Visit(job, errors=table).forecast().verdict == "pass"
    holed = np.where(np.arange(93) == 3, np.nan, errors["ex_um"])
    with pytest.raises(nonius.Problem, match="is empty in one row of axis X"):
        nonius.Visit(job, errors=errors | {"ex_um": cells(holed)}).forecast()


def test_what_was_given_is_kept(job, errors):
    visit = nonius.Visit(job, errors=errors)
    kit = visit.generate()
    errors["ex_um"] *= 3
    job["acceptance"]["max_deviation_um"] = 1e-9
    assert kit.verify().verdict == "pass" and pickle.loads(pickle.dumps(kit)).verify().verdict == "pass"
    assert pickle.loads(pickle.dumps(kit.verify())).verdict == "pass"
    with pytest.raises(KeyError):
        kit.verify().terms.array("at_mots_um")


def test_every_problem_is_named_at_once(job, errors):
    job["machine"]["axes"]["x"]["travle_mm"] = [0, 900]
    job["acceptance"]["max_deviation_um"] = -1
    with pytest.raises(nonius.Problem) as caught:
        nonius.Visit(job, errors=errors).generate()
    assert len(caught.value.all) >= 2 and "travel_mm" in str(caught.value)
    job["acceptance"]["max_deviation_um"] = np.inf
    with pytest.raises(nonius.Problem, match="no infinite numbers"):
        nonius.Visit(job, errors=errors).generate()


def test_what_the_program_writes_is_in_the_answer_alone(job, errors, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    nonius.Visit(job, errors=errors).generate()
    assert list(tmp_path.iterdir()) == []


def test_wrong_usage_is_a_problem():
    with pytest.raises(nonius.Problem, match="--wrong"):
        nonius.ask("assess", "--wrong")
    with pytest.raises(TypeError, match="names its tables itself"):
        nonius.Visit("job.toml", errors={"axis": []}).generate()


def test_assess_and_standards(job, errors):
    volume = nonius.Visit(job, errors=errors).assess()
    assert volume.va_um == pytest.approx(36.854726) and len(volume.to_pandas()) == 9
    diagonals = nonius.Visit(FIXTURES / "diagonals/case_d_bidirectional/job.toml").standards()
    assert diagonals.document["schema"] == 1


def test_other_threads_go_on(job, errors):
    """While the program computes, the interpreter is free."""
    visit = nonius.Visit(FIXTURES / "diagonals/case_d_bidirectional/job.toml")
    work = threading.Thread(target=lambda: visit.separate(trials=20_000))
    work.start()
    turns = 0
    while work.is_alive():
        time.sleep(0.001)
        turns += 1
    assert turns > 20
