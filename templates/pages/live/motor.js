"use strict";
// What a board prints is text: it enters the page by textContent alone, and the drawing only by columns' names, which are words.

const MOST = 2000; // points of a curve when it is fetched; at three times as many it is fetched anew
const PATIENCE_MS = 5000; // for the answer to a command
const CODES = ["flags", "sensors", "alarms", "protection"];

const fixed = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits);
const duration = (seconds) => seconds < 120 ? `${fixed(seconds, 0)} s` : `${fixed(Math.floor(seconds / 60), 0)} min`;

// One motor: what of the page is its own, its rows, its commands. `place` counts from 1; `about` does not change.
class Motor {
  constructor(place, about) {
    Object.assign(this, {place, about, number: 0, next: 0, status: 0, columns: [], curves: {}, last: {}, sensors: [], asked: Promise.resolve(), drawn: 0, dirty: false, fetching: false, stream: null});
    this.suffix = place === 1 ? "" : `-${place}`;
  }

  by(id) { return document.getElementById(id + this.suffix); }

  put(id, text) { const node = this.by(id); if (node.textContent !== text) node.textContent = text; }

  components() { return this.columns.filter((name) => name.endsWith("_degC") && !name.endsWith("_model_degC")).map((name) => name.slice(0, -5)); }

  // ---- what the page shows of it ----

  // Its part of the page, under names of its own.
  build(alone) {
    const own = document.getElementById("motor").content.cloneNode(true);
    for (const node of own.querySelectorAll("[id]")) node.id += this.suffix;
    for (const name of ["for", "aria-labelledby"]) for (const node of own.querySelectorAll(`[${name}]`)) node.setAttribute(name, node.getAttribute(name) + this.suffix);
    document.getElementById("motors").appendChild(own);
    const {about} = this;
    this.put("name", `${alone ? "" : `Motor ${this.place}: `}${about.name} (${about.kind})`);
    if (!alone) this.by("alarms").setAttribute("aria-label", `Alarms of motor ${this.place}`);
    this.by("file").href = `${this.place}/run.csv`;
    this.put("recorded", about.recorded_to ? `; recorded to ${about.recorded_to}` : "");
    this.by("board").hidden = !about.takes_commands;
    this.by("heat-note").hidden = !about.heat.rules.length;
    this.by("controls").hidden = !about.controls.length;
    this.by("controls-list").append(...about.controls.map((told) => this.control(told)));
    this.by("arm").addEventListener("click", () => this.ask("arm", {armed: this.by("arm").getAttribute("aria-pressed") !== "true"}));
    this.by("pwm-form").addEventListener("submit", (event) => { event.preventDefault(); this.ask("pwm", {count: Number(this.by("pwm").value)}); });
    // When it is pressed: an alarm that appears above moves the button, and one that is let go elsewhere is no click. Keys have no press.
    this.by("halt").addEventListener("pointerdown", (event) => { if (!event.button && !this.by("halt").disabled) this.ask("pwm", {count: 0}); });
    this.by("halt").addEventListener("click", (event) => { if (!event.detail) this.ask("pwm", {count: 0}); });
    this.by("line-form").addEventListener("submit", async (event) => { event.preventDefault(); if (await this.ask("line", {text: this.by("line").value})) this.by("line").value = ""; });
  }

  control(told) {
    const box = document.createElement("div"), label = document.createElement("label"), id = `control-${told.name.replace(/\W/g, "-")}${this.suffix}`;
    const numeric = told.form === "number" || told.form === "slider";
    label.textContent = told.label; label.htmlFor = id;
    const field = document.createElement(told.form === "choice" ? "select" : "input");
    for (const text of told.options) { const option = document.createElement("option"); option.textContent = text; option.value = text; field.appendChild(option); }
    if (told.form !== "choice") field.type = {number: "number", slider: "range", text: "text"}[told.form];
    if (numeric) { field.min = told.low; field.max = told.high; field.step = told.form === "slider" ? told.step : "any"; }
    field.id = id; field.value = told.value;
    box.append(label, field);
    if (told.form === "slider") {
      const value = document.createElement("output");
      value.htmlFor.add(id); value.textContent = field.value;
      field.addEventListener("input", () => { value.textContent = field.value; });
      box.append(value);
    }
    field.addEventListener("change", () => this.ask("change", {name: told.name, value: numeric ? Number(field.value) : field.value}));
    return box;
  }

  showNow() {
    const {last} = this, body = this.by("now"), names = this.components();
    while (body.rows.length > names.length) body.deleteRow(-1);
    names.forEach((name, place) => {
      const row = body.rows[place] || body.insertRow();
      while (row.cells.length < 6) row.appendChild(document.createElement(row.cells.length ? "td" : "th"));
      const measured = last[`${name}_degC`], model = last[`${name}_model_degC`], low = last[`${name}_low`], high = last[`${name}_high`];
      const difference = measured == null || model == null ? null : measured - model;
      const sensor = this.sensors.find((one) => one.channel === name || one.channel === `${name}_degC`);
      const texts = [name, fixed(measured, 2), fixed(model, 2), fixed(difference, 2), low == null ? "–" : `${fixed(low, 1)} to ${fixed(high, 1)}`, sensor ? sensor.state : "–"];
      texts.forEach((text, k) => { if (row.cells[k].textContent !== text) row.cells[k].textContent = text; });
      row.cells[3].className = measured != null && low != null && (measured < low || measured > high) ? "bad" : "";
      row.cells[5].className = sensor && sensor.state !== "ok" ? "bad" : "";
    });
    const {input, heat} = this.about, drive = [`time ${fixed(last.time_s, 1)} s`, `PWM ${fixed(last.pwm, 0)}${input ? ` (${input})` : ""}`];
    if (last.speed_rpm != null) drive.push(`speed ${fixed(last.speed_rpm, 0)} rpm`);
    if (last.time_to_limit_s != null) drive.push(`no limit for ${duration(last.time_to_limit_s)} at this PWM`);
    if (last.holdable_pwm != null) drive.push(`PWM ${fixed(last.holdable_pwm, 0)} can be held`);
    this.put("drive", drive.join(", "));
    const missing = heat.rules.filter((rule) => last[rule.column] != null).map((rule) => `${rule.rule} ${fixed(last[rule.column], 0)} % of ${rule.threshold_K} K`);
    this.put("heat", missing.length ? `Missing heat (${heat.told}): ${missing.join(", ")}` : "");
  }

  showStatus(status) {
    if (status.number < this.status) return; // looked up before what is shown
    this.status = status.number;
    this.put("link", status.link);
    this.by("dot").className = status.connected ? "dot on" : "dot";
    this.put("rows", String(status.rows)); this.put("garbled", String(status.garbled)); this.put("restarts", String(status.restarts));
    this.put("alarms", [
      status.alarms.length ? `Alarm: ${status.alarms.join(", ")}` : "",
      status.acts.length ? `The board acts on: ${status.acts.join(", ")}` : "",
    ].filter(Boolean).join(". "));
    this.put("lines", [...status.lines].reverse().join("\n"));
    const {led, relay, told} = status.signals, signals = [led && `LED: ${led}`, relay && `Relay: ${relay}`].filter(Boolean);
    this.put("signals", signals.length ? `${signals.join(". ")} (${told}).` : "");
    this.by("signals").className = relay === "open" ? "bad" : "";
    this.sensors = status.sensors;
    const armed = status.armed_s > 0;
    this.by("board").className = armed ? "board armed" : "board";
    this.by("arm").setAttribute("aria-pressed", String(armed));
    this.put("arm", armed ? "Disarm" : "Arm");
    this.put("armed", armed ? `armed for ${status.armed_s} s more: commands go to the board` : "not armed: nothing is sent");
    for (const button of this.by("board").querySelectorAll(".sends")) button.disabled = !armed;
    this.showNow();
  }

  // ---- what the server tells it, and is told ----

  // One after another: two that are under way at once may arrive in either order, and a stop must not overtake what it stops.
  ask(path, body) {
    this.asked = this.asked.then(() => this.post(path, body));
    return this.asked;
  }

  async post(path, body) {
    try {
      const request = {method: "POST", headers: {"content-type": "application/json", "x-gen-live": "1"}, body: JSON.stringify(body), signal: AbortSignal.timeout(PATIENCE_MS)};
      const answer = await fetch(`${this.place}/${path}`, request), told = await answer.json().catch(() => ({}));
      this.put("refused", answer.ok ? "" : String(told.error || `refused (${answer.status})`));
      if (answer.ok) this.showStatus(told);
      return answer.ok;
    } catch { // what is asked next has to go on
      this.put("refused", "gen live did not answer: it is not known whether this was done");
      return false;
    }
  }

  take(told) {
    if (told.part !== this.number || told.columns.length !== this.columns.length) { this.refresh(); return; }
    for (const row of told.rows) {
      this.columns.forEach((name, k) => {
        this.last[name] = row[k];
        if (!k || CODES.includes(name)) return;
        const curve = this.curves[name] || (this.curves[name] = [[], []]);
        curve[0].push(row[0]); curve[1].push(row[k]);
      });
    }
    this.next += told.rows.length;
    if (told.rows.length) this.dirty = true;
    if ((this.curves.pwm || [[]])[0].length > 3 * MOST) this.refresh();
  }

  async refresh() {
    if (this.fetching) return;
    this.fetching = true;
    if (this.stream) this.stream.close();
    try {
      const told = await (await fetch(`${this.place}/history?most=${MOST}`)).json();
      Object.assign(this, {number: told.part, next: told.next, columns: told.columns, curves: told.curves});
      this.showStatus(told.status);
      this.dirty = true;
      this.listen();
    } catch { this.status = 0; setTimeout(() => this.refresh(), 1000); } finally { this.fetching = false; }
  }

  listen() {
    // Columns that came empty so far have no curve yet; the browser opens the stream again by itself, from the last row on.
    const stream = this.stream = new EventSource(`${this.place}/events?part=${this.number}&row=${Math.max(0, this.next - 1)}`);
    let first = this.next > 0;
    stream.onmessage = (event) => {
      const told = JSON.parse(event.data);
      if (first && told.part === this.number && told.rows.length) { // the row before, for the table alone
        this.columns.forEach((name, k) => { this.last[name] = told.rows[0][k]; });
        told.rows.shift();
      }
      first = false;
      this.take(told);
      this.showStatus(told.status);
    };
    stream.onerror = () => { this.status = 0; this.put("link", "gen live does not answer; trying again"); this.by("dot").className = "dot"; }; // another server counts anew
  }
}
