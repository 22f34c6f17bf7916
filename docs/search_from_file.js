// Search in pages that are opened from disk, where browsers start no workers: a hidden frame does the work.
"use strict";
if (location.protocol === "file:") window.Worker = class extends EventTarget {
  constructor(url) {
    super();
    const frame = this.frame = document.createElement("iframe");
    frame.hidden = true;
    document.body.append(frame);
    const inner = frame.contentWindow, load = address => new Promise(done => {
      const script = inner.document.createElement("script");
      Object.assign(script, { src: address, onload: done });
      inner.document.body.append(script);
    });
    inner.postMessage = data => this.hand(this, data); // what the work says comes here
    inner.importScripts = (...urls) => urls.reduce((before, each) => before.then(() => load(each)), Promise.resolve());
    this.ready = load(url);
  }
  hand(target, data) {
    const event = new MessageEvent("message", { data });
    target.dispatchEvent(event);
    if (target === this && this.onmessage) this.onmessage(event);
  }
  postMessage(data) { this.ready.then(() => this.hand(this.frame.contentWindow, data)); }
  terminate() { this.frame.remove(); }
};
