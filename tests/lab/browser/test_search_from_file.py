"""The site's search where there is no server: a worker that a browser would not start."""

from pathlib import Path

SCRIPT = Path(__file__).resolve().parents[3] / "docs" / "search_from_file.js"
PAGE = """<html><body><script src="{script}"></script><script>
const worker = new Worker("worker.js");
worker.onmessage = event => {{ document.title = event.data; }};
worker.postMessage(20);
</script></body></html>"""
WORKER = """importScripts("one.js").then(() => {
    addEventListener("message", event => postMessage(2 * event.data + one));
});"""


def test_a_worker_answers_from_the_disk(page, tmp_path):
    (tmp_path / "index.html").write_text(PAGE.format(script=SCRIPT.as_uri()))
    (tmp_path / "worker.js").write_text(WORKER)
    (tmp_path / "one.js").write_text("var one = 1;")
    page.goto((tmp_path / "index.html").as_uri())
    page.wait_for_timeout(300)
    page.evaluate("worker.postMessage(20)")  # the first one came before its script
    page.wait_for_function("document.title === '41'", timeout=10_000)
