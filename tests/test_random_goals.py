"""Tables over random goals: what is delivered, and which first turns are feasible."""

import pytest
from test_reproduce import JOB, row

from baselines.reproduce import fig5_paths, plane


def test_goals_over_the_plane_against_a_case_worked_by_hand():
    unclosed = row(0.02, 0.0, closure=None, success=True)
    rows = [row(0.01, 0.1, success=True), unclosed, row(0.03, -0.3), row(0.08, 0.6)]
    study = [{"policy": "paper", "scenario": "nominal", "limit": 180.0, "episodes": rows}]
    product = plane.table(JOB, study)
    assert product["rows"] == [
        {
            "policy": "paper",
            "scenario": "nominal",
            "time limit (s)": 180.0,
            "episodes": 4,
            "closed": "75%",
            "delivered": "50.0% [15.0, 85.0]",  # Wilson's interval of 2 in 4
            "within 5 cm, 0.1 rad": "50%",
            "within 10 cm, 0.5 rad": "75%",
        }
    ]
    (note,) = product["notes"]
    assert "goals 0.4 to 1.2 m" in note
    assert "within 5 cm and 0.1 rad for 3 s" in note


def test_first_turns_against_values_computed_in_another_way(monkeypatch):
    """A scan over first turns on other goals gave these; 4,000 goals here."""
    monkeypatch.setattr(fig5_paths, "GOALS", 4000)
    printed, chosen = fig5_paths.first_turns(JOB)["rows"]
    shares = [float(row["feasible"].rstrip("%")) for row in (printed, chosen)]
    assert shares == pytest.approx([78.3, 98.2], abs=2.0)
    assert printed["50 %"] == pytest.approx(4.83, rel=0.08)
    assert chosen["50 %"] == pytest.approx(1.070, abs=0.01)
    assert all(row["50 %"] < row["75 %"] < row["95 %"] for row in (printed, chosen))
