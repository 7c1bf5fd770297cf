def test_the_site_is_built_and_named_in_json(answer, tmp_path):
    found = answer("site", "--output", "public")
    assert (tmp_path / found["start"]).is_file()
    assert {"page", "bytes"} == {*found["pages"][0]}
    assert found["unlinked"]


def test_bad_input_is_status_2_and_leaves_nothing(harness, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("")
    said = harness("site", "--output", "mine", status=2).stderr
    assert "--output mine: holds thesis.tex, which no site wrote" in said
    said = harness("site", "absent", "--output", "public", status=2).stderr
    assert "RUN absent: is not a run of verify" in said
    assert not (tmp_path / "public").exists()
