// What a live page and a replay share: camera, shadows, status, plots, switches of overlays.
"use strict";
const Linefoot = (() => {
  const make = (parent, tag, attributes = {}, text = "") => {
    const element = Object.assign(document.createElement(tag), attributes);
    if (text) element.textContent = text;
    if (parent) parent.append(element);
    return element;
  };
  const number = value => (value === null || value === undefined ? "–" : value.toFixed(2).replace(/^-(?=0\.00$)/, ""));
  const brief = value => value.toFixed(Math.abs(value) < 10 ? 2 : 0);
  const wrap = angle => Math.atan2(Math.sin(angle), Math.cos(angle));

  // Follows the robot, which is drawn over the origin: "follow" keeps the camera's direction,
  // "chase" turns with the robot, "free" leaves the camera where it is in the world.
  class Camera {
    constructor(viewer, torso) {
      Object.assign(this, { viewer, torso, mode: "follow", yaw: null, offset: null, then: 0 });
    }
    node(path) {
      return path.reduce((node, name) => node && node.children[name], this.viewer.scene_tree);
    }
    update(now) {
      const torso = this.node(this.torso), drake = this.node(["drake"]);
      if (!torso || !drake) return;
      const { w, x, y, z } = torso.object.quaternion, moved = drake.object.position;
      const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
      const { camera, controls } = this.viewer, step = Math.min(0.1, (now - this.then) / 1000);
      this.then = now;
      if (this.mode === "chase" && this.yaw !== null) {
        const turn = wrap(yaw - this.yaw) * (1 - Math.exp(-step / 0.3));
        const arm = camera.position.clone().sub(controls.target);
        const c = Math.cos(turn), s = Math.sin(turn); // about the vertical, which is y here
        camera.position.set(
          controls.target.x + c * arm.x + s * arm.z, camera.position.y,
          controls.target.z - s * arm.x + c * arm.z);
        this.yaw += turn;
        if (Math.abs(turn) > 1e-5) this.changed();
      } else this.yaw = yaw;
      if (this.mode === "free" && this.offset) {
        const by = moved.clone().sub(this.offset);
        if (by.length() > 1e-6) {
          for (const place of [camera.position, controls.target]) {
            place.x += by.x; place.y += by.z; place.z -= by.y;
          }
          this.changed();
        }
      }
      this.offset = moved.clone();
    }
    changed() { this.viewer.controls.update(); this.viewer.set_dirty(); }
    choose(parent) {
      const select = make(parent, "select", { ariaLabel: "camera", title: "camera (C)" });
      for (const mode of ["follow", "chase", "free"]) make(select, "option", { value: mode }, mode);
      select.onchange = () => { this.mode = select.value; select.blur(); };
      this.next = () => { select.selectedIndex = (select.selectedIndex + 1) % 3; select.onchange(); };
      return select;
    }
  }

  // The light that throws shadows reaches as far as they are seen.
  const sharpen = viewer => {
    viewer.gui.domElement.style.display = "none"; // our own switches are beside it
    const light = viewer.scene_tree.find(["Lights", "FillLight", "<object>"]).object;
    const { camera, mapSize } = light.shadow;
    Object.assign(camera, { left: -2.5, right: 2.5, top: 2.5, bottom: -2.5 });
    camera.updateProjectionMatrix();
    mapSize.set(2048, 2048);
    if (light.shadow.map) { light.shadow.map.dispose(); light.shadow.map = null; } // of another size, it would put all in the dark
    light.shadow.normalBias = 0.01;
    viewer.set_dirty();
  };

  const SIDES = ["#ff6f6a", "#62a3ff"]; // left is red and right is blue, and nothing else is
  const OTHERS = ["#f2f4f8", "#d9b36c", "#8f9db3"];

  class Plot {
    constructor(parent, title, unit, names, least, colours) {
      Object.assign(this, { title, unit, names, least, colours });
      this.canvas = make(parent, "canvas", { className: "lf-plot" });
    }
    // times: rising; rows: values of each time; now: where a line is drawn, or null
    draw(times, rows, begin, end, now) {
      const { canvas, colours } = this, ratio = window.devicePixelRatio || 1;
      const w = canvas.clientWidth, h = canvas.clientHeight, top = 15;
      canvas.width = w * ratio; canvas.height = h * ratio;
      const g = canvas.getContext("2d");
      g.scale(ratio, ratio);
      g.font = "10px system-ui, sans-serif";
      let low = Infinity, high = -Infinity;
      times.forEach((t, k) => t >= begin && t <= end && rows[k].forEach(v => {
        if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
      }));
      if (low > high) { low = 0; high = 0; }
      const slack = Math.max(0, this.least - (high - low)) / 2;
      low -= slack; high += slack;
      const x = t => ((t - begin) / (end - begin)) * w, y = v => h - 2 - ((v - low) / (high - low)) * (h - top - 4);
      g.fillStyle = "#0e131b"; g.fillRect(0, top, w, h - top);
      g.strokeStyle = "#45536a";
      if (low < 0 && high > 0) { g.beginPath(); g.moveTo(0, y(0)); g.lineTo(w, y(0)); g.stroke(); }
      this.names.forEach((name, i) => {
        g.strokeStyle = colours[i]; g.lineWidth = 1.2; g.beginPath();
        let begun = false;
        times.forEach((t, k) => {
          const v = rows[k][i];
          if (t < begin || t > end || v === null) { begun = false; return; }
          begun ? g.lineTo(x(t), y(v)) : g.moveTo(x(t), y(v));
          begun = true;
        });
        g.stroke();
      });
      g.fillStyle = "#9fb0c8"; if (w > 160) g.fillText(`${this.title} ${this.unit}`, 0, 10);
      let right = w;
      [...this.names].reverse().forEach((name, k) => {
        right -= g.measureText(name).width + 5;
        g.fillStyle = colours[this.names.length - 1 - k]; g.fillText(name, right, 10);
      });
      for (const [value, at] of [[high, top + 9], [low, h - 3]]) { // legible over the lines
        const text = brief(value);
        g.fillStyle = "#0e131bcc"; g.fillRect(0, at - 9, g.measureText(text).width + 4, 11);
        g.fillStyle = "#9fb0c8"; g.fillText(text, 2, at);
      }
      if (now !== null) { g.fillStyle = "#fff"; g.fillRect(x(now), top, 1, h - top); }
    }
  }

  // Status, plots and overlays, at the upper left.
  class Overlay {
    // legend: names of overlays and their colours; viewer: returns Meshcat's, once there is one
    constructor(legend, viewer) {
      const box = this.box = make(document.body, "div", { className: "lf lf-status", hidden: !legend.length });
      this.fell = make(box, "div", { className: "lf-fell" });
      const table = make(box, "table"), more = make(box, "div", { className: "lf-note" });
      this.note = more;
      const row = (parent, name, n) => {
        const tr = make(parent, "tr");
        make(tr, "td", {}, name);
        return Array.from({ length: n }, () => make(tr, "td", n === 1 ? { colSpan: 3 } : {}));
      };
      row(table, "", 3).forEach((cell, k) => { cell.textContent = ["forward", "left", "turn"][k]; });
      this.cells = { asked: row(table, "commanded", 3), walks: row(table, "measured", 3), time: row(table, "time", 1) };
      const plots = make(box, "div", { className: "lf-plots" });
      this.plots = { walks: new Plot(plots, "velocity", "m/s, rad/s", ["forward", "left", "turn"], 0.2, OTHERS),
        force: new Plot(plots, "force", "f_z N", ["left", "right"], 50, SIDES),
        tilt: new Plot(plots, "torso", "deg", ["roll", "pitch"], 4, OTHERS) };
      const fold = title => {
        const details = make(box, "details");
        make(details, "summary", {}, title);
        return details;
      };
      const rest = make(fold("details"), "table");
      Object.assign(this.cells, { feet: row(rest, "on ground", 1), solver: row(rest, "MPC, WBC", 1), source: row(rest, "state", 1),
        push: row(rest, "push", 1) });
      const drawn = fold("what is drawn; a click hides it"), small = matchMedia("(max-width: 700px), (max-height: 640px)");
      (small.onchange = () => { drawn.open = !small.matches; })();
      const list = make(drawn, "div", { className: "lf-legend" });
      for (const [name, colours] of legend) {
        const item = make(list, "label", { title: `${name}: show or hide` });
        const check = make(item, "input", { type: "checkbox", checked: true });
        for (const colour of colours) make(item, "i").style.background = colour;
        item.append(name);
        check.onchange = () => {
          this.switched[name] = check.checked;
          this.apply();
          check.blur();
        };
      }
      Object.assign(this, { switched: {}, viewer });
    }
    apply() { // again and again: what is begun anew is seen
      for (const [name, seen] of Object.entries(this.switched)) this.viewer().scene_tree.find(["overlays", name]).object.visible = seen;
      this.viewer().set_dirty();
    }
    show(state) {
      for (const name of ["asked", "walks"])
        this.cells[name].forEach((cell, k) => { cell.textContent = number(state[name][k]); });
      this.cells.time[0].textContent = `${state.time.toFixed(2)} s, ${state.rate}`;
      for (const name of ["feet", "solver", "source"]) this.cells[name][0].textContent = state[name];
      this.cells.push[0].textContent = `${state.push.toFixed(0)} N`;
      this.fell.textContent = state.fell ? `FELL: ${state.fell}` : "";
      if (Object.keys(this.switched).length) this.apply();
      const note = state.note || (state.solver.includes("NOT") ? state.solver : "");
      if (this.note.textContent !== note) this.note.textContent = note;
    }
    draw(times, rows, begin, end, now = null) {
      for (const [name, plot] of Object.entries(this.plots)) plot.draw(times, rows[name], begin, end, now);
    }
  }
  return { Camera, Overlay, make, sharpen };
})();
