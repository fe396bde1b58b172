"""The HTML report in a headless Chromium: nothing on the console, every layer's pixels, a place that is flown to, widths, print.

Usage: page_test.py PATCHWRIGHT SAMPLES_DIR PICTURES [unittest arguments]
PICTURES is a folder for screenshots. Exit code 77: no Chromium, or the reports' program was not bundled.
"""
import base64
import math
import pathlib
import re
import struct
import sys
import tempfile
import unittest
import xml.etree.ElementTree
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "cli"))
from browser import Browser, PROGRAM
from command_line import CliTest, run, SAMPLES, WING

PICTURES = pathlib.Path(sys.argv[3])
MOST_BYTES = 5e6
# Of the canvas: shares of pixels that are drawn, and of these grey, blue, red, black and white; how many different colours.
COUNT = """(() => {
  const canvas = document.querySelector('.view canvas'), copy = document.createElement('canvas');
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext('2d');
  pen.drawImage(canvas, 0, 0);
  const p = pen.getImageData(0, 0, copy.width, copy.height).data;
  const n = {drawn: 0, grey: 0, blue: 0, red: 0, black: 0, white: 0}, colours = new Set();
  for (let i = 0; i < p.length; i += 4) {
    if (p[i + 3] < 255) continue;
    const [r, g, b] = [p[i], p[i + 1], p[i + 2]];
    ++n.drawn;
    n.grey += Math.max(r, g, b) - Math.min(r, g, b) < 24;
    n.blue += b > r + 24 && b > g + 8;
    n.red += r > b + 24 && r > g + 24;
    n.black += Math.max(r, g, b) < 50;
    n.white += Math.min(r, g, b) > 200;
    colours.add(r >> 4 << 8 | g >> 4 << 4 | b >> 4);
  }
  for (const key of ['grey', 'blue', 'red', 'black', 'white']) n[key] /= n.drawn;
  n.drawn /= p.length / 4;
  return {...n, colours: colours.size};
})()"""


def shares_of_png(png):
    """Of pixels that are not transparent, and of these blue ones, in a PNG as reports hold it: RGBA, differences to the row above."""
    width, height = struct.unpack(">II", png[16:24])
    rows = zlib.decompress(png[png.index(b"IDAT") + 4:png.index(b"IEND") - 8])
    above, drawn, blue = bytes(4 * width), 0, 0
    for y in range(height):
        row = rows[y * (4 * width + 1):(y + 1) * (4 * width + 1)]
        assert row[0] == 2
        above = bytes((a + b) & 255 for a, b in zip(above, row[1:]))
        for x in range(0, 4 * width, 4):
            if above[x + 3] > 0:
                drawn += 1
                blue += above[x + 2] > above[x]
    return drawn / (width * height), blue / drawn


def numbers(text):
    return [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)]


def place_of(told):
    return numbers(told.split("(")[1].split(")")[0])


class Pages(CliTest):
    @classmethod
    def setUpClass(cls):
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="patchwright"))
        cls.page = cls.made / "wing.html"
        result = run("convert", WING / "wing.igs", "--cage", WING / "wing_cage.obj", "-o", cls.made / "wing.step", "--report", cls.page)
        assert result.returncode == 0, result.stderr
        cls.browser = Browser()
        PICTURES.mkdir(parents=True, exist_ok=True)

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()

    def open(self, file, width=1200, **options):
        self.browser.messages.clear()
        self.browser.open(file, width, **options)
        self.browser.wait_for("document.documentElement.dataset.ready === 'true'")
        self.assertEqual(self.browser.messages, [])

    def layer(self, name):
        """Pixels after a click on it, which turns those off that were on and no colours."""
        self.browser.click(f'input[value="{name}"]')
        return self.browser.run(COUNT)

    def told_at(self, right, down):
        """What is told of the output after a click so many pixels from the middle of its half; empty beside the surface."""
        x, y = self.browser.run("(() => { const r = document.querySelector('.view canvas').getBoundingClientRect();"
                                "return [r.x + 0.75 * r.width, r.y + r.height / 2]; })()")
        self.browser.run("document.querySelector('.readout').textContent = ''")
        self.browser.click_at(x + right, y + down)
        return self.browser.run("document.querySelector('.readout').textContent")

    def inches_a_pixel(self):
        """On the surface, near the middle of the output's half."""
        step = 30
        told = {(i, j): self.told_at(step * i, step * j) for i in (-1, 0, 1) for j in (-1, 0, 1)}
        return min(math.dist(place_of(told[a]), place_of(told[b])) / step for a in told for b in told
                   if told[a] and told[b] and math.dist(a, b) == 1)

    def test_layers(self):
        self.open(self.page)
        self.layer("places to look at")
        self.layer("sharp and free edges")  # now without both
        seen = {name: self.layer(name) for name in ("plain", "deviation", "normal angle", "patches", "curvature", "zebra stripes")}
        for name, pixels in seen.items():
            with self.subTest(name):
                self.assertGreater(pixels["drawn"], 0.05)
        self.assertGreater(seen["plain"]["grey"], 0.99)
        self.assertGreater(seen["deviation"]["blue"], 0.5)  # 5.2e-5 of 1e-4
        self.assertEqual(seen["deviation"]["red"], 0)
        self.assertGreater(seen["normal angle"]["blue"], 0.5)
        self.assertGreater(seen["patches"]["red"], 0.2)
        self.assertLess(seen["patches"]["grey"], 0.1)
        self.assertGreater(seen["curvature"]["blue"], 0.02)  # the nose bends away
        self.assertGreater(seen["zebra stripes"]["black"], 0.15)
        self.assertGreater(seen["zebra stripes"]["white"], 0.15)
        for name in ("control mesh", "extraordinary vertices", "sharp and free edges", "places to look at"):
            before = self.browser.run(COUNT)
            self.assertNotEqual(self.layer(name), before, name)
        self.assertEqual(self.browser.messages, [])
        self.browser.screenshot(PICTURES / "layers.png")

    def test_a_place_is_flown_to_and_a_click_tells_figures(self):
        self.open(self.page)
        before = self.inches_a_pixel()
        text = self.browser.run("document.querySelector('.places button').textContent")
        self.browser.click(".places li:first-child button")
        self.browser.wait_for("document.querySelector('.view').dataset.place === '0'")
        # A seventh of the diagonal wide now, all of it before; the surface turns away from the view.
        self.assertLess(3.0 * self.inches_a_pixel(), before)
        # The place is in the middle of the output's half; what is told there is what the list says.
        self.browser.click('input[value="places to look at"]')
        told = self.told_at(0, 0)
        self.assertIn("output, face", told)
        listed = numbers(text.split("(")[1].split(")")[0])
        for a, b in zip(place_of(told), listed):
            self.assertAlmostEqual(a, b, delta=1.5)  # inches, of 129: a few pixels
        deviation = float(re.search(r"deviation ([\d.e-]+) in", told).group(1))
        self.assertLess(abs(deviation - numbers(text)[0]), 0.6 * numbers(text)[0])
        self.browser.screenshot(PICTURES / "place.png")
        self.assertEqual(self.browser.messages, [])

    def test_narrow_dark_and_print(self):
        for width, dark in ((400, False), (400, True), (1200, True)):
            with self.subTest(width=width, dark=dark):
                self.open(self.page, width, dark=dark)
                self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"), width)
                self.assertGreater(self.browser.run(COUNT)["drawn"], 0.05)
                ground = self.browser.run("getComputedStyle(document.body).backgroundColor")
                self.assertEqual(ground == "rgb(255, 255, 255)", not dark)
                self.browser.screenshot(PICTURES / f"{width}_{'dark' if dark else 'light'}.png", whole=True)
        self.assertGreater(len(re.findall(rb"/Type\s*/Page\b", self.browser.pdf())), 0)

    def test_plots(self):
        self.open(self.page)
        self.assertEqual(self.browser.run("document.querySelectorAll('figure.plot .uplot').length"), 2)
        self.assertEqual(self.browser.run("document.querySelectorAll('figure.plot svg').length"), 0)

    def test_without_a_program(self):
        self.browser.open(self.page, 1200, script=False)
        self.browser.screenshot(PICTURES / "no_script.png", whole=True)
        text = self.page.read_text()
        drawings = re.findall(r"<svg.*?</svg>", text, re.DOTALL)
        self.assertEqual(len(drawings), 2)
        for drawing in drawings:
            self.assertEqual(len(xml.etree.ElementTree.fromstring(drawing).findall(".//*[@class='curve']")), drawing.count("series"))
        drawn, blue = shares_of_png(base64.b64decode(re.search(r"base64,([^\"]+)", text).group(1)))
        self.assertGreater(drawn, 0.1)
        self.assertGreater(blue, 0.5)
        self.assertIn('<img alt="The output and its patches', text)
        self.assertLess(text.index("met 1e-4"), text.index("<img"))  # the verdict first
        for tag in ("title", "h1"):
            self.assertIn(f"<{tag}>convert wing.igs \u2192 wing.step</{tag}>", text)
        self.assertIn("<tr><td>tolerance</td><td>1e-4rel</td></tr>", text.split("<h2>Options</h2>")[1])
        self.assertNotIn("http://", re.sub(r"http://www.w3.org/\S*", "", text.split("<script")[0]))

    def test_other_commands(self):
        for name, arguments, layers in (
                ("compare", ["compare", WING / "wing.igs", self.made / "wing.step"], 6),
                ("inspect", ["inspect", WING / "wing.igs"], 4),
                ("export", ["export", SAMPLES / "cages" / "genus2.obj", "-o", self.path("a.step")], 4),
                ("fit", ["fit", WING / "wing.step", "--cage", WING / "wing_cage.obj", "-o", self.path("a.obj"), "--tolerance", "1e-2rel"], 0),
                ("grid", ["grid", SAMPLES / "cages" / "cube.obj", "-o", self.path("a.cgns"), "--points", 9], 0)):
            with self.subTest(name):
                page = self.path(f"{name}.html")
                result = run(*arguments, "--report", page)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertLess(page.stat().st_size, MOST_BYTES)
                self.browser.messages.clear()
                self.browser.open(page, 1200)
                self.assertEqual(self.browser.run("document.querySelectorAll('input[name=layer]').length"), layers)
                self.assertEqual(self.browser.messages, [])
                if name == "grid":
                    drawn, _ = shares_of_png(base64.b64decode(re.search(r"base64,([^\"]+)", page.read_text()).group(1)))
                    self.assertGreater(drawn, 0.1)
        self.assertLess(self.page.stat().st_size, MOST_BYTES)


if __name__ == "__main__":
    if PROGRAM is None:
        print("SKIPPED: Chromium is not installed")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "cube.html"
        run("export", SAMPLES / "cages" / "cube.obj", "-o", f"{folder}/a.step", "--report", page)
        if "<script" not in page.read_text():
            print("SKIPPED: this build has no program for reports, as there was no npm")
            sys.exit(77)
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
