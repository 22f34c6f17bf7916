"""A headless Chromium, and where its screenshots go; without one these tests are skipped."""

import shutil
from pathlib import Path

import pytest

OUT = Path(__file__).resolve().parents[3] / "out" / "browser"
FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
]
NAMES = ("chromium", "chromium-browser", "google-chrome")
# Four pictures a second: drawn in software as fast as it can, a page takes more than a core from
# what it shows, and from the tests beside it.
FEW_PICTURES = """
const draw = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = callback => window.setTimeout(() => draw(callback), 250);
"""


@pytest.fixture(scope="session")
def browser():
    """Chromium, drawing in software."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no Chromium: apt-get install chromium")
    api = pytest.importorskip("playwright.sync_api", reason="no playwright: pip install playwright")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def page(browser):
    """A page that must not complain of anything; Meshcat's own icon may be missing."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    errors = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.add_init_script(FEW_PICTURES)
    yield page
    page.close()
    assert errors == []


@pytest.fixture
def shot(page, request):
    """Save a screenshot under out/browser/."""

    def save(name):
        OUT.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=OUT / f"{name}.png")

    return save
