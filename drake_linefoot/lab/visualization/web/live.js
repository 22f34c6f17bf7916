// The live page of a drive, a walk or a robot: Meshcat in a frame, and what its program sets up.
"use strict";
(() => {
  const { make } = Linefoot, frame = document.getElementById("view"), canvas = document.getElementById("grab");
  const WINDOW = 6, TOUCHED = 600, REPEAT = 100; // [s] of the plots; [ms] a slider is the user's, between steps of a held key
  const sliders = {}, buttons = {}, folds = {}, times = [], rows = { walks: [], force: [], tilt: [] };
  let socket, camera, overlay, hint, files, state = null, drag = null, held = null, stick = "null", moved = false, ended = false;
  const send = order => socket && socket.readyState === 1 && socket.send(JSON.stringify(order));
  const press = name => { held = null; send({ press: name }); };

  function connect() {
    socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[^/]*$/, ""));
    socket.onmessage = message => {
      const said = JSON.parse(message.data);
      if (said.setup) build(said.setup);
      if (said.state && overlay) show(said.state);
    };
    socket.onclose = () => {
      if (ended) return;
      if (overlay) overlay.note.textContent = "no connection";
      setTimeout(connect, 1000);
    };
  }

  function build(setup) {
    if (overlay) return;
    document.title = setup.title;
    overlay = new Linefoot.Overlay(setup.legend, () => camera.viewer);
    hint = make(document.body, "button", { type: "button", className: "lf lf-hint" });
    const box = make(document.body, "div", { className: "lf lf-controls" }), first = make(box, "div");
    const fold = name => {
      if (!name) return first;
      if (folds[name]) return folds[name];
      const details = make(box, "details");
      make(details, "summary", {}, name);
      return folds[name] = make(details, "div");
    };
    for (const each of setup.sliders) {
      const label = make(fold(each.fold), "label"), name = make(label, "span", {}, each.label);
      for (const key of [each.more, each.less]) if (key) make(name, "kbd", {}, key.slice(3));
      const output = make(label, "output");
      const input = make(label, "input", { type: "range", min: each.least, max: each.largest, step: "any" });
      const slider = sliders[each.name] = { ...each, input, output, touched: 0 };
      input.oninput = () => set(slider, +input.value);
      input.onchange = () => input.blur(); // keys are for the robot
      display(slider, each.value);
    }
    for (const { name, label, key, fold: where } of setup.buttons) {
      const parent = fold(where), row = parent.row = parent.row || make(parent, "div", { className: "lf-row" });
      if (!setup.legend.length) parent.prepend(row); // many sliders follow
      const button = buttons[name] = make(row, "button", { type: "button" }, label);
      button.dataset.action = name;
      button.onclick = () => { press(name); button.blur(); };
      if (key) make(button, "kbd", {}, ["↑", "↓", "←", "→"][["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"].indexOf(key)]
        || key.replace("Key", "").replace("Period", ".").replace("Escape", "Esc"));
    }
    files = make(buttons.record ? buttons.record.parentNode.parentNode : first, "div", { className: "lf-row" });
    const view = make(box, "div", { className: "lf-row" });
    camera = new Linefoot.Camera(null, setup.torso);
    view.append("camera", camera.choose(view));
    make(view, "kbd", {}, "C");
    if (setup.help) make(view, "span", { title: setup.help, className: "lf-help" }, "?");
    const actions = Object.fromEntries(setup.buttons.filter(b => b.key).map(b => [b.key, b.name]));
    const keys = event => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (actions[event.code]) {
        event.preventDefault(); // Space and arrows do not scroll, nor press what was clicked
        if (!event.repeat) press(actions[event.code]);
      } else if (event.code === "KeyC") camera.next();
      else if (!event.repeat) for (const slider of Object.values(sliders)) {
        const sign = (event.code === slider.more) - (event.code === slider.less);
        if (sign) { let_go(); held = { slider, sign, code: event.code, from: slider.value, then: performance.now() }; step(); }
      }
    };
    const up = event => { if (held && event.code === held.code) let_go(); };
    addEventListener("keydown", keys);
    addEventListener("keyup", up);
    addEventListener("blur", () => { if (document.activeElement !== frame) let_go(); });
    const begin = () => {
      const inner = frame.contentWindow;
      if (!inner.viewer) { setTimeout(begin, 50); return; }
      window.viewer = camera.viewer = inner.viewer;
      make(inner.document.head, "style", {}, "#status-message { display: none !important; }"); // the note says it
      inner.addEventListener("keydown", keys);
      inner.addEventListener("keyup", up);
      Linefoot.sharpen(inner.viewer);
      if (sliders.push) watch(inner);
    };
    begin();
    frame.addEventListener("load", begin);
    requestAnimationFrame(tick);
  }

  // A key that is held steps its slider on; one that steers goes back where it was when it is let go.
  function step(count = 1) {
    const { slider, sign } = held;
    set(slider, slider.step * Math.round(slider.value / slider.step + sign * count));
  }

  function let_go() {
    if (held && held.slider.steers) set(held.slider, held.from);
    held = null;
  }

  function set(slider, value) {
    value = Math.min(slider.largest, Math.max(slider.least, value));
    slider.touched = performance.now();
    display(slider, value);
    send({ set: [slider.name, value] });
  }

  function display(slider, value) {
    slider.value = value;
    slider.input.value = value;
    slider.output.textContent = value.toFixed(slider.step < 0.01 ? 3 : 2);
  }

  function show(now) {
    if (now.ended) { ended = true; overlay.note.textContent = "it has ended"; return; }
    state = now;
    for (const [name, value] of Object.entries(now.values)) {
      const slider = sliders[name]; // one that is moved here does not jump back
      if (value !== slider.value && performance.now() > slider.touched + TOUCHED) display(slider, value);
    }
    for (const [name, button] of Object.entries(buttons)) button.classList.toggle("on", now.on.includes(name));
    if (now.time === undefined) return; // a robot to look at
    overlay.show(now);
    if (times.length && now.time < times.at(-1)) { times.length = 0; for (const name in rows) rows[name].length = 0; moved = false; }
    moved = moved || now.asked.some(v => v);
    advise(now);
    if (files.dataset.names !== now.files.join()) {
      files.dataset.names = now.files.join();
      files.replaceChildren(...now.files.map(file => make(null, "a", { href: `files/${file}`, download: file }, file)));
    }
    if (now.time === times.at(-1)) return;
    times.push(now.time);
    for (const name in rows) rows[name].push(now[name]);
    while (times[0] < now.time - WINDOW) { times.shift(); for (const name in rows) rows[name].shift(); }
  }

  // What to press next, large; it can be clicked.
  function advise(now) {
    const [text, act] = !buttons.reset ? [""] : now.fell ? ["It fell. R begins again", () => press("reset")]
      : now.on.includes("pause") ? ["Paused. Space goes on", () => press("pause")]
      : moved ? [""] : ["Press W to walk", () => set(sliders.forward, 5 * sliders.forward.step)];
    hint.style.display = text ? "block" : "none";
    if (hint.textContent !== text) hint.textContent = text;
    hint.onclick = () => { act(); hint.blur(); };
  }

  function tick(now) {
    requestAnimationFrame(tick);
    if (camera.viewer) camera.update(now);
    if (!state) return;
    const steps = held ? Math.floor((performance.now() - held.then) / REPEAT) : 0;
    if (steps) { held.then += steps * REPEAT; step(steps); }
    if (times.length) overlay.draw(times, rows, Math.max(0, state.time - WINDOW), Math.max(state.time, WINDOW));
    const pad = [...(navigator.getGamepads ? navigator.getGamepads() : [])].find(p => p && p.connected);
    const axes = pad && pad.axes.length > 1 ? [-pad.axes[1], -pad.axes[0], -(pad.axes[2] || 0)] : null;
    const seen = JSON.stringify(axes && axes.map(a => Math.round(a * 100) / 100));
    if (seen !== stick) { stick = seen; send({ stick: JSON.parse(seen) }); }
    pull();
  }

  // A spring from where the robot was grabbed to the pointer, in a plane that faces the camera.
  function watch(inner) {
    const { THREE } = inner.MeshCat, pane = inner.document.getElementById("meshcat-pane");
    const ray = event => {
      const caster = new THREE.Raycaster(), { innerWidth: w, innerHeight: h } = inner;
      caster.setFromCamera({ x: (2 * event.clientX) / w - 1, y: 1 - (2 * event.clientY) / h }, camera.viewer.camera);
      return caster;
    };
    pane.addEventListener("pointerdown", event => {
      const robot = camera.node(camera.torso.slice(0, -1));
      if (event.button !== 0 || !robot) return;
      const [hit] = ray(event).intersectObject(robot.object, true).filter(h => h.object.isMesh);
      if (!hit) return;
      event.stopPropagation();
      pane.setPointerCapture(event.pointerId);
      const normal = camera.viewer.camera.getWorldDirection(new THREE.Vector3());
      drag = { THREE, object: hit.object, local: hit.object.worldToLocal(hit.point.clone()), to: hit.point.clone(),
        plane: new THREE.Plane().setFromNormalAndCoplanarPoint(normal, hit.point) };
    }, true);
    pane.addEventListener("pointermove", event => {
      if (!drag) return;
      event.stopPropagation();
      ray(event).ray.intersectPlane(drag.plane, drag.to);
    }, true);
    for (const name of ["pointerup", "pointercancel"])
      pane.addEventListener(name, event => {
        if (!drag) return;
        event.stopPropagation();
        drag = null;
        send({ drag: null });
      }, true);
  }

  function pull() {
    const g = canvas.getContext("2d");
    if (canvas.width !== innerWidth || canvas.height !== innerHeight) Object.assign(canvas, { width: innerWidth, height: innerHeight });
    g.clearRect(0, 0, canvas.width, canvas.height);
    if (!drag) return;
    const from = drag.object.localToWorld(drag.local.clone()), by = drag.to.clone().sub(from);
    send({ drag: [by.x, -by.z, by.y] }); // to z up
    const at = frame.getBoundingClientRect(), [a, b] = [from, drag.to].map(p => {
      const on = p.clone().project(camera.viewer.camera);
      return [at.x + ((on.x + 1) / 2) * at.width, at.y + ((1 - on.y) / 2) * at.height];
    });
    g.strokeStyle = g.fillStyle = "rgb(242, 115, 13)";
    g.lineWidth = 3;
    g.beginPath(); g.moveTo(...a); g.lineTo(...b); g.stroke();
    g.beginPath(); g.arc(...b, 6, 0, 7); g.fill();
    g.font = "13px system-ui, sans-serif";
    g.fillText(`${state.push.toFixed(0)} N`, b[0] + 10, b[1] - 8);
  }
  connect();
})();
