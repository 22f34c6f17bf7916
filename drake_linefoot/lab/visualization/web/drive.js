// The driving page: controls, keys, gamepad and pointer, around Meshcat in a frame.
"use strict";
(() => {
  const { make } = Linefoot, frame = document.getElementById("view"), canvas = document.getElementById("grab");
  const WINDOW = 6, TOUCHED = 600; // [s] of the plots; [ms] a slider is the user's
  let socket, camera, overlay, sliders = {}, buttons = {}, state = null, downloads, drag = null, stick = "null", ended = false;
  const times = [], rows = { walks: [], force: [], tilt: [] };
  const send = order => socket && socket.readyState === 1 && socket.send(JSON.stringify(order));
  const press = name => send({ press: name });

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
    overlay = new Linefoot.Overlay(setup.legend);
    const box = make(document.body, "div", { className: "lf lf-controls" });
    const row = () => make(box, "div", { className: "lf-row" });
    const group = make(box, "div", { className: "lf-sliders" });
    for (const slider of setup.sliders) {
      const label = make(group, "label");
      const keys = slider.more ? ` (${slider.more.slice(3)} ${slider.less.slice(3)})` : "";
      make(label, "span", {}, slider.label + keys);
      const output = make(label, "output");
      const input = make(label, "input", { type: "range", min: slider.least, max: slider.largest, step: slider.step });
      sliders[slider.name] = { ...slider, input, output, touched: 0 };
      input.oninput = () => set(sliders[slider.name], +input.value);
      input.onchange = () => input.blur(); // keys are for the robot
      display(sliders[slider.name], slider.value);
    }
    const rows = { drive: row(), aim: row(), time: row(), model: row() };
    const place = { stop: rows.drive, push: rows.drive, reset: rows.drive, quit: rows.drive, record: rows.time, pause: rows.time,
      step: rows.time, estimate: rows.time };
    for (const { name, label, key } of setup.buttons) {
      const parent = place[name] || (name.startsWith("push ") ? rows.aim : rows.model);
      const button = buttons[name] = make(parent, "button", { type: "button" }, label);
      button.dataset.action = name;
      button.onclick = () => { press(name); button.blur(); };
      const shown = key.replace(/^Key|^Arrow/, "").replace("Period", ".").replace("Escape", "Esc");
      if (key) make(button, "kbd", {}, shown);
      if (name.startsWith("push ")) {
        button.textContent = { forward: "↑", backward: "↓", left: "←", right: "→" }[name.slice(5)];
        button.title = label;
      }
    }
    rows.aim.prepend("aim of push");
    const view = row();
    view.append("camera");
    camera = new Linefoot.Camera(null, setup.torso);
    camera.choose(view);
    make(view, "kbd", {}, "C");
    downloads = row();
    const help = make(box, "details");
    make(help, "summary", {}, "more");
    make(help, "div", {}, "Drag the robot with the mouse: a spring pulls its torso to the pointer. Gamepad: left stick walks, right stick turns.");
    const actions = Object.fromEntries(setup.buttons.filter(b => b.key).map(b => [b.key, b.name]));
    const keys = event => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (actions[event.code]) {
        event.preventDefault(); // Space and arrows do not scroll, nor press what was clicked
        if (!event.repeat) press(actions[event.code]);
        return;
      }
      if (event.code === "KeyC") camera.next();
      for (const slider of Object.values(sliders)) {
        const sign = (event.code === slider.more) - (event.code === slider.less);
        if (sign) set(slider, Math.min(slider.largest, Math.max(slider.least, slider.value + sign * slider.step)));
      }
    };
    addEventListener("keydown", keys);
    const begin = () => {
      const inner = frame.contentWindow;
      if (!inner.viewer) { setTimeout(begin, 50); return; }
      window.viewer = camera.viewer = inner.viewer;
      inner.addEventListener("keydown", keys);
      make(inner.document.head, "style", {}, "#status-message { display: none !important; }"); // the note says it
      inner.viewer.gui.domElement.style.display = "none";
      Linefoot.sharpen(inner.viewer);
      watch(inner);
    };
    begin();
    frame.addEventListener("load", begin);
    requestAnimationFrame(tick);
  }

  function set(slider, value) {
    value = Math.round(value / slider.step) * slider.step;
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
    if (now.ended) { ended = true; overlay.note.textContent = "the drive has ended"; return; }
    state = now;
    overlay.show({ ...now, fell: now.fell && `${now.fell}. R begins again` });
    const note = now.clip.note || now.remark || (now.limited && `command limited: ${now.limited}`);
    if (overlay.note.textContent !== note) overlay.note.textContent = note;
    for (const [name, value] of Object.entries(now.values)) {
      const slider = sliders[name]; // one that is moved here does not jump back
      if (value !== slider.value && performance.now() > slider.touched + TOUCHED) display(slider, value);
    }
    for (const [name, button] of Object.entries(buttons))
      button.classList.toggle("on", name === now.model || name === now.aim || (name === "pause" && now.paused) || (name === "estimate" && now.estimate) || (name === "record" && now.clip.recording));
    const files = now.clip.files.join();
    if (downloads.dataset.files !== files) {
      downloads.dataset.files = files;
      downloads.replaceChildren(...now.clip.files.map(file => make(null, "a", { href: `files/${file}`, download: file }, file)));
    }
    if (times.length && now.time < times.at(-1)) { times.length = 0; for (const name in rows) rows[name].length = 0; }
    if (now.time === times.at(-1)) return;
    times.push(now.time);
    for (const name in rows) rows[name].push(now[name]);
    while (times[0] < now.time - WINDOW) { times.shift(); for (const name in rows) rows[name].shift(); }
  }

  function tick(now) {
    requestAnimationFrame(tick);
    if (!state) return;
    if (camera.viewer) camera.update(now);
    overlay.draw(times, rows, Math.max(0, state.time - WINDOW), Math.max(state.time, WINDOW));
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
