"use strict";
// What a board prints is text: it enters the page by textContent alone, and the drawing only by columns' names, which are words.

const MOST = 2000; // points of a curve when it is fetched; at three times as many it is fetched anew
const DRAW_MS = 500;
const CODES = ["flags", "sensors", "alarms", "protection"];
const part = {number: 0, next: 0, status: 0, columns: [], curves: {}, last: {}};
let about = null, stream = null, shownWindow = 0, dirty = false, fetching = false, drawn = 0;

const by = (id) => document.getElementById(id);
const put = (id, text) => { const node = by(id); if (node.textContent !== text) node.textContent = text; };
const fixed = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits);

const duration = (seconds) => seconds < 120 ? `${fixed(seconds, 0)} s` : `${fixed(Math.floor(seconds / 60), 0)} min`;

async function ask(path, body) {
  const answer = await fetch(path, {method: "POST", headers: {"content-type": "application/json", "x-gen-live": "1"}, body: JSON.stringify(body)});
  const told = await answer.json().catch(() => ({}));
  put("refused", answer.ok ? "" : String(told.error || `refused (${answer.status})`));
  if (answer.ok) showStatus(told);
  return answer.ok;
}

// ---- the parts ----

const components = () => part.columns.filter((name) => name.endsWith("_degC") && !name.endsWith("_model_degC")).map((name) => name.slice(0, -5));

function showNow() {
  const last = part.last, body = by("now");
  const names = components();
  while (body.rows.length > names.length) body.deleteRow(-1);
  names.forEach((name, place) => {
    const row = body.rows[place] || body.insertRow();
    while (row.cells.length < 6) row.appendChild(document.createElement(row.cells.length ? "td" : "th"));
    const measured = last[`${name}_degC`], model = last[`${name}_model_degC`], low = last[`${name}_low`], high = last[`${name}_high`];
    const difference = measured == null || model == null ? null : measured - model;
    const sensor = (part.sensors || []).find((one) => one.channel === name || one.channel === `${name}_degC`);
    const texts = [name, fixed(measured, 2), fixed(model, 2), fixed(difference, 2), low == null ? "–" : `${fixed(low, 1)} to ${fixed(high, 1)}`, sensor ? sensor.state : "–"];
    texts.forEach((text, k) => { if (row.cells[k].textContent !== text) row.cells[k].textContent = text; });
    row.cells[3].className = measured != null && low != null && (measured < low || measured > high) ? "bad" : "";
    row.cells[5].className = sensor && sensor.state !== "ok" ? "bad" : "";
  });
  const drive = [`time ${fixed(last.time_s, 1)} s`, `PWM ${fixed(last.pwm, 0)}${about.input ? ` (${about.input})` : ""}`];
  if (last.speed_rpm != null) drive.push(`speed ${fixed(last.speed_rpm, 0)} rpm`);
  if (last.time_to_limit_s != null) drive.push(`no limit for ${duration(last.time_to_limit_s)} at this PWM`);
  if (last.holdable_pwm != null) drive.push(`PWM ${fixed(last.holdable_pwm, 0)} can be held`);
  put("drive", drive.join(", "));
  const heat = about.heat.rules.filter((rule) => last[rule.column] != null).map((rule) => `${rule.rule} ${fixed(last[rule.column], 0)} % of ${rule.threshold_K} K`);
  put("heat", heat.length ? `Missing heat (${about.heat.told}): ${heat.join(", ")}` : "");
}

function showStatus(status) {
  if (status.number < part.status) return; // looked up before what is shown
  part.status = status.number;
  put("link", status.link);
  by("dot").className = status.connected ? "dot on" : "dot";
  put("rows", String(status.rows)); put("garbled", String(status.garbled)); put("restarts", String(status.restarts));
  put("alarms", [
    status.alarms.length ? `Alarm: ${status.alarms.join(", ")}` : "",
    status.acts.length ? `The board acts on: ${status.acts.join(", ")}` : "",
  ].filter(Boolean).join(". "));
  put("lines", [...status.lines].reverse().join("\n"));
  part.sensors = status.sensors;
  const {led, relay, told} = status.signals, signals = [led && `LED: ${led}`, relay && `Relay: ${relay}`].filter(Boolean);
  put("signals", signals.length ? `${signals.join(". ")} (${told}).` : "");
  by("signals").className = relay === "open" ? "bad" : "";
  const armed = status.armed_s > 0;
  by("board").className = armed ? "armed" : "";
  by("arm").setAttribute("aria-pressed", String(armed));
  put("arm", armed ? "Disarm" : "Arm");
  put("armed", armed ? `armed for ${status.armed_s} s more: commands go to the board` : "not armed: nothing is sent");
  for (const button of document.querySelectorAll(".sends")) button.disabled = !armed;
  showNow();
}

// ---- the curves ----

const seen = (name) => (part.curves[name] || [[], []])[1].some((value) => value != null);

// From below: PWM and speed, time to limit and missing heat where there are any, the temperatures.
function panels() {
  const shown = [["yaxis2", 1], ["yaxis5", seen("time_to_limit_s") ? 1 : 0], ["yaxis4", about.heat.rules.some((rule) => seen(rule.column)) ? 1 : 0], ["yaxis", 3]].filter((panel) => panel[1]);
  const whole = shown.reduce((sum, panel) => sum + panel[1], 0), gap = 0.06, domains = {};
  let low = 0;
  for (const [name, share] of shown) {
    const high = low + share / whole;
    domains[name] = [low, Math.min(1, high - (name === "yaxis" ? 0 : gap))];
    low = high;
  }
  return domains;
}

function traces() {
  const found = [], line = (name, own) => Object.assign({x: (part.curves[name] || [[], []])[0], y: (part.curves[name] || [[], []])[1], mode: "lines", hoverinfo: "x+y+name", connectgaps: false}, own);
  components().forEach((name, place) => {
    const colour = about.colours[place % about.colours.length];
    if (part.curves[`${name}_low`]) {
      found.push(line(`${name}_low`, {line: {width: 0}, showlegend: false, hoverinfo: "skip"}));
      found.push(line(`${name}_high`, {line: {width: 0}, fill: "tonexty", fillcolor: `${colour}22`, showlegend: false, hoverinfo: "skip"}));
    }
    found.push(line(`${name}_degC`, {name, legendgroup: name, line: {color: colour, width: 1.6}}));
    if (part.curves[`${name}_model_degC`]) found.push(line(`${name}_model_degC`, {name: `${name}, model`, legendgroup: name, line: {color: colour, width: 1.4, dash: "dot"}}));
  });
  found.push(line("pwm", {name: "PWM", yaxis: "y2", line: {color: about.ink, shape: "hv"}}));
  if (seen("holdable_pwm")) found.push(line("holdable_pwm", {name: "PWM that can be held", yaxis: "y2", line: {color: about.ink, dash: "dot", shape: "hv"}}));
  about.heat.rules.filter((rule) => seen(rule.column)).forEach((rule, place) => {
    found.push(line(rule.column, {name: `missing heat, ${rule.rule}`, yaxis: "y4", line: {color: about.colours[(place + components().length) % about.colours.length], width: 1.8, shape: "hv", dash: ["solid", "dash", "dot"][place % 3]}}));
  });
  if (seen("time_to_limit_s")) found.push(line("time_to_limit_s", {name: "time to limit, s", yaxis: "y5", line: {color: about.ink, width: 1.4}}));
  if (part.curves.speed_rpm) found.push(line("speed_rpm", {name: "speed, rpm", yaxis: "y3", line: {color: about.ink, dash: "dash", width: 1}}));
  return found;
}

function draw() {
  if (!dirty || document.hidden || !about) return;
  dirty = false;
  const style = getComputedStyle(document.body), times = (part.curves.pwm || [[]])[0], now = times.length ? times[times.length - 1] : 0;
  const axis = {gridcolor: style.getPropertyValue("--rule"), zeroline: false, automargin: true};
  const domains = panels(), layout = {
    datarevision: ++drawn, // the curves grow where they are: without it they would be taken for unchanged
    uirevision: `${part.number}`, margin: {l: 50, r: 50, t: 10, b: 40}, showlegend: true, legend: {orientation: "h", yref: "container", y: 0, yanchor: "bottom"},
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: {color: style.color},
    xaxis: {...axis, title: {text: "time, s"}, anchor: "y2", ...(shownWindow ? {range: [now - shownWindow, now + 0.03 * shownWindow], uirevision: now} : {})},
    yaxis: {...axis, title: {text: "°C"}, domain: domains.yaxis},
    yaxis2: {...axis, title: {text: "PWM"}, domain: domains.yaxis2, rangemode: "tozero"},
    yaxis3: {title: {text: "rpm"}, overlaying: "y2", side: "right", showgrid: false, zeroline: false, rangemode: "tozero", tickmode: "auto", nticks: 4},
  };
  if (domains.yaxis4) layout.yaxis4 = {...axis, title: {text: "heat, %"}, domain: domains.yaxis4, rangemode: "tozero"};
  if (domains.yaxis5) layout.yaxis5 = {...axis, title: {text: "limit, s"}, domain: domains.yaxis5, rangemode: "tozero"};
  if (domains.yaxis4) layout.shapes = [{type: "line", xref: "paper", x0: 0, x1: 1, yref: "y4", y0: 100, y1: 100, line: {color: style.getPropertyValue("--bad"), width: 1, dash: "dash"}}]; // there the alarm is raised
  const panelled = String(Object.keys(domains).length), grown = by("plot").dataset.panels !== panelled;
  by("plot").dataset.panels = panelled; // more of them are higher together
  Plotly.react("plot", traces(), layout, {responsive: true, displaylogo: false});
  if (grown) Plotly.Plots.resize("plot");
  Object.assign(by("plot").dataset, {points: String(times.length), until: String(now)}); // what was drawn, for who looks at it from outside
}

function take(told) {
  if (told.part !== part.number || told.columns.length !== part.columns.length) { refresh(); return; }
  for (const row of told.rows) {
    part.columns.forEach((name, k) => {
      part.last[name] = row[k];
      if (!k || CODES.includes(name)) return;
      const curve = part.curves[name] || (part.curves[name] = [[], []]);
      curve[0].push(row[0]); curve[1].push(row[k]);
    });
  }
  part.next += told.rows.length;
  if (told.rows.length) dirty = true;
  if ((part.curves.pwm || [[]])[0].length > 3 * MOST) refresh();
}

async function refresh() {
  if (fetching) return;
  fetching = true;
  if (stream) stream.close();
  try {
    const told = await (await fetch(`history?most=${MOST}`)).json();
    part.number = told.part; part.next = told.next; part.columns = told.columns; part.curves = told.curves;
    showStatus(told.status);
    dirty = true;
    listen();
  } catch { part.status = 0; setTimeout(refresh, 1000); } finally { fetching = false; }
}

function listen() {
  // Columns that came empty so far have no curve yet; the browser opens the stream again by itself, from the last row on.
  stream = new EventSource(`events?part=${part.number}&row=${Math.max(0, part.next - 1)}`);
  let first = part.next > 0;
  stream.onmessage = (event) => {
    const told = JSON.parse(event.data);
    if (first && told.part === part.number && told.rows.length) { // the row before, for the table alone
      part.columns.forEach((name, k) => { part.last[name] = told.rows[0][k]; });
      told.rows.shift();
    }
    first = false;
    take(told);
    showStatus(told.status);
  };
  stream.onerror = () => { part.status = 0; put("link", "gen live does not answer; trying again"); by("dot").className = "dot"; }; // another server counts anew
}

// ---- what the page can do ----

function control(told) {
  const box = document.createElement("div"), label = document.createElement("label"), id = `control-${told.name.replace(/\W/g, "-")}`;
  label.textContent = told.label; label.htmlFor = id;
  let field;
  if (told.form === "choice") {
    field = document.createElement("select");
    for (const text of told.options) { const option = document.createElement("option"); option.textContent = text; option.value = text; field.appendChild(option); }
  } else {
    field = document.createElement("input");
    field.type = told.form === "number" ? "number" : "text";
    if (told.form === "number") { field.min = told.low; field.max = told.high; field.step = "any"; }
  }
  field.id = id; field.value = told.value;
  field.addEventListener("change", () => ask("change", {name: told.name, value: told.form === "number" ? Number(field.value) : field.value}));
  box.append(label, field);
  return box;
}

async function begin() {
  about = await (await fetch("about")).json();
  document.title = `${about.name}: gen live`;
  put("name", `${about.name} (${about.kind})`);
  put("recorded", about.recorded_to ? `; recorded to ${about.recorded_to}` : "");
  by("board").hidden = !about.takes_commands;
  by("controls").hidden = !about.controls.length;
  by("controls-list").append(...about.controls.map(control));
  by("arm").addEventListener("click", () => ask("arm", {armed: by("arm").getAttribute("aria-pressed") !== "true"}));
  by("pwm-form").addEventListener("submit", (event) => { event.preventDefault(); ask("pwm", {count: Number(by("pwm").value)}); });
  by("halt").addEventListener("click", () => ask("pwm", {count: 0}));
  by("line-form").addEventListener("submit", async (event) => { event.preventDefault(); if (await ask("line", {text: by("line").value})) by("line").value = ""; });
  for (const button of document.querySelectorAll("#windows button")) {
    button.addEventListener("click", () => {
      shownWindow = Number(button.dataset.window);
      for (const other of document.querySelectorAll("#windows button")) other.setAttribute("aria-pressed", String(other === button));
      dirty = true; draw();
    });
  }
  setInterval(draw, DRAW_MS);
  await refresh();
}

begin();
