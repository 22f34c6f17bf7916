// A replay: status, plots and a play bar, over the one file that Meshcat makes.
"use strict";
Linefoot.replay = data => {
  const { make } = Linefoot, overlay = new Linefoot.Overlay(data.legend, () => viewer);
  const camera = new Linefoot.Camera(viewer, data.torso), { time } = data, end = time.at(-1);
  const bar = make(document.body, "div", { className: "lf lf-bar" });
  const play = make(bar, "button", { type: "button", title: "Space" }, "pause");
  const slider = make(bar, "input", { type: "range", min: 0, max: end, step: "any", ariaLabel: "time" });
  const clock = make(bar, "span"), segment = make(bar, "span", { className: "lf-segment" });
  const speed = make(bar, "select", { ariaLabel: "speed" });
  for (const x of [0.1, 0.25, 0.5, 1, 2]) make(speed, "option", { value: x, selected: x === 1 }, `${x} ×`);
  speed.onchange = () => { viewer.animator.mixer.timeScale = +speed.value; speed.blur(); };
  camera.choose(bar);
  let finished = false, mixer = null;
  const now = () => { // its last picture is that of the end
    const { actions, duration } = viewer.animator, t = actions.length ? actions[0].time : 0;
    return duration && t >= duration ? end : t;
  };
  const seek = t => {
    finished = false; // played out and led elsewhere within one picture: it stays there
    viewer.animator.pause();
    viewer.animator.seek(Math.min(end, Math.max(0, t)));
  };
  const toggle = () => {
    finished = false;
    if (viewer.animator.playing) { viewer.animator.pause(); return; }
    if (now() >= end) viewer.animator.seek(0);
    viewer.animator.play();
  };
  play.onclick = () => { toggle(); play.blur(); };
  slider.oninput = () => seek(+slider.value);
  slider.onchange = () => slider.blur();
  addEventListener("keydown", event => {
    const step = { ArrowLeft: -1 / 32, ArrowRight: 1 / 32 }[event.code];
    if (event.code === "Space") toggle();
    else if (step) seek(now() + step);
    else if (event.code === "KeyC") { camera.next(); return; } else return;
    event.preventDefault();
  });
  Linefoot.sharpen(viewer);
  let drawn = "";
  const tick = frame => {
    requestAnimationFrame(tick);
    camera.update(frame);
    if (mixer !== viewer.animator.mixer) { // the recording has come
      mixer = viewer.animator.mixer;
      mixer.addEventListener("finished", () => { finished = true; });
    }
    if (finished && !viewer.animator.playing) seek(end); // Meshcat has rewound its clock, but not the scene
    play.textContent = viewer.animator.playing ? "pause" : "play";
    const t = now(), seen = `${t} ${innerWidth} ${innerHeight}`;
    if (seen === drawn) return;
    drawn = seen;
    let k = time.findIndex(each => each > t + 1e-9) - 1;
    if (k < 0) k = t < time[0] ? 0 : time.length - 1;
    const fell = data.fell && t >= end - 0.05 ? data.fell : "";
    overlay.show({ time: t + data.begin, rate: `${speed.value} × real time`, asked: data.asked[k], walks: data.walks[k],
      feet: data.feet[k], solver: data.solver[k], source: data.source[k], push: data.push[k], fell, note: "" });
    overlay.draw(time, data, 0, end, t);
    if (document.activeElement !== slider) slider.value = t;
    clock.textContent = `${(t + data.begin).toFixed(2)} of ${(end + data.begin).toFixed(2)} s`;
    segment.textContent = data.segments.filter(([begin]) => begin <= t + 1e-9).at(-1)[1];
  };
  requestAnimationFrame(tick);
};
