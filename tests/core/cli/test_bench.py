"""``cpm bench`` prints the same measurements as a table and as JSON."""

import json


def test_the_json_has_a_positive_time_for_each_line_of_the_table(command):
    status, out, err = command("bench", "--quick", "--json")
    facts = json.loads(out)
    assert (status, err) == (0, "")
    assert facts["machine"]["cores"] >= 1
    assert all(row["value"] > 0.0 and row["unit"] == "ms" for row in facts["measurements"])
    status, out, err = command("bench", "--quick")
    assert (status, err) == (0, "")
    for row, line in zip(facts["measurements"], out.splitlines(), strict=False):
        assert line.startswith(row["what"].rsplit(" particles")[0][:30])
