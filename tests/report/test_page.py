import re
from html.parser import HTMLParser

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robustnav.errors import InputError
from robustnav.report import figures
from robustnav.report.page import Page, Tile

VOID = {"meta", "link", "br", "img", "use", "path"}


class Checker(HTMLParser):
    """Raises on tags that do not nest; collects ids, addresses and the text."""

    def __init__(self):
        super().__init__()
        self.open, self.tags, self.ids, self.addresses, self.said = [], [], [], [], []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        given = dict(attributes)
        self.ids += [given["id"]] if "id" in given else []
        self.addresses += [v for k, v in attributes if k in ("src", "href", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.said.append(data)


def check(html):
    checker = Checker()
    checker.feed(html)
    assert not checker.open
    return checker


def full_page(make_sample):
    run, _, log = make_sample()
    page = Page("Title <1>", "Sub & title")
    page.verdict("ok", "Fine.", ["because"])
    page.section("Numbers")
    page.tiles([Tile("Total", "1.08", "deg", "RMS")])
    page.table([{"estimator": "H2", "total_deg": 1.0}, {"estimator": "EKF", "total_deg": float("nan")}], "Scores")
    page.figure(figures.bias(run))
    page.figure(figures.bias(run))
    page.figure(figures.timeline(list(log.streams.values())))
    page.notes(["careful"], "warning")
    page.settings({"imu": "mpu9250", "gate": None}, {"robustnav": "0"}, "robustnav run a.ulg")
    return page


def test_page_is_well_formed_and_needs_nothing_from_outside(make_sample):
    html = full_page(make_sample).html()
    found = check(html)
    assert all(address.startswith("#") for address in found.addresses)
    assert {address[1:] for address in found.addresses} <= set(found.ids)
    assert set(re.findall(r"url\(#([^)]+)\)", html)) <= set(found.ids)
    assert len(found.ids) == len(set(found.ids))
    assert not {"script", "link", "img", "iframe", "metadata"} & set(found.tags)
    assert "url(http" not in html and "@import" not in html
    assert '<meta name="viewport"' in html and "Figure 3." in html


def test_equal_content_gives_equal_bytes(make_sample):
    html = full_page(make_sample).html()
    assert html == full_page(make_sample).html()
    assert not re.search(r"20\d\d-\d\d", html)


nasty = st.text(alphabet=st.sampled_from("<>&\"'/abc{}%s \n"), max_size=20)


@settings(deadline=None, max_examples=60)
@given(nasty, nasty)
def test_every_text_is_escaped(one, two):
    page = Page(one, two)
    page.section(one)
    page.text(two)
    page.verdict("error", one, [two])
    page.tiles([Tile(one, two, one, two)])
    page.table([{one: two, "x" + two: 1.0}], one)
    page.notes([one, two], "warning")
    page.settings({one: two}, {two: one}, one)
    allowed = {"html", "head", "meta", "title", "style", "body", "main", "header", "p", "h1", "h2", "h3", "div"}
    allowed |= {"strong", "ul", "li", "dl", "dt", "dd", "span", "table", "caption", "thead", "tbody", "tr", "th", "td"}
    found = check(page.html())
    assert set(found.tags) <= allowed | {"pre", "code"}
    assert one in found.said or not one


def test_a_figure_label_cannot_break_out_of_the_svg(make_sample):
    run, _, _ = make_sample()
    plot = figures.bias(run)
    page = Page("t")
    page.figure(type(plot)(plot.figure, 'a "quoted" <b>caption</b> --> & more'))
    assert "b" not in check(page.html()).tags


def test_numbers_stand_right_and_words_left():
    page = Page("t")
    page.table([{"estimator": "H2", "total_deg": 1.25}], "Scores")
    html = page.html()
    assert '<th scope="col">Estimator</th><th scope="col" class="number">Total, deg</th>' in html
    assert '<td>H2</td><td class="number">1.25</td>' in html
    page.table([], "never shown")
    page.notes([])
    assert page.html() == html


def test_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    page = Page("first")
    path = page.write(tmp_path / "new" / "page.html")
    assert path.read_text(encoding="utf-8") == page.html()
    assert [p.name for p in path.parent.iterdir()] == ["page.html"]

    def broken(self, target):
        raise OSError("disk full")

    monkeypatch.setattr("pathlib.Path.replace", broken)
    with pytest.raises(InputError, match="disk full"):
        Page("second").write(path)
    assert "first" in path.read_text(encoding="utf-8")
    assert [p.name for p in path.parent.iterdir()] == ["page.html"]


def test_a_folder_is_no_page(tmp_path):
    with pytest.raises(InputError, match="a folder"):
        Page("t").write(tmp_path)
    with pytest.raises(InputError, match=r"got +object"):
        Page("t").settings({"a": object()}, {})
