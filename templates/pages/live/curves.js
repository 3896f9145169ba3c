"use strict";
// A motor's curves: which there are, in which panels, over which time.

const seen = (motor, name) => (motor.curves[name] || [[], []])[1].some((value) => value != null);
const heatRules = (motor) => motor.about.heat.rules.filter((rule) => seen(motor, rule.column));

// From below: PWM and speed, time to limit and missing heat where there are any, the temperatures.
function panels(motor) {
  const shown = [["yaxis2", 1], ["yaxis5", seen(motor, "time_to_limit_s") ? 1 : 0], ["yaxis4", heatRules(motor).length ? 1 : 0], ["yaxis", 3]].filter((panel) => panel[1]);
  const whole = shown.reduce((sum, panel) => sum + panel[1], 0), gap = 0.06, domains = {};
  let low = 0;
  for (const [name, share] of shown) {
    const high = low + share / whole;
    domains[name] = [low, Math.min(1, high - (name === "yaxis" ? 0 : gap))];
    low = high;
  }
  return domains;
}

function traces(motor, page) {
  const colour = (place) => page.colours[place % page.colours.length], ink = page.ink, parts = motor.components(), found = [];
  const add = (name, own) => {
    const [x, y] = motor.curves[name] || [[], []];
    found.push(Object.assign({x, y, mode: "lines", hoverinfo: "x+y+name", connectgaps: false}, own));
  };
  parts.forEach((name, place) => {
    if (motor.curves[`${name}_low`]) {
      add(`${name}_low`, {line: {width: 0}, showlegend: false, hoverinfo: "skip"});
      add(`${name}_high`, {line: {width: 0}, fill: "tonexty", fillcolor: `${colour(place)}22`, showlegend: false, hoverinfo: "skip"});
    }
    add(`${name}_degC`, {name, legendgroup: name, line: {color: colour(place), width: 1.6}});
    if (motor.curves[`${name}_model_degC`]) add(`${name}_model_degC`, {name: `${name}, model`, legendgroup: name, showlegend: false, line: {color: colour(place), width: 1.4, dash: "dot"}});
  });
  add("pwm", {name: "PWM", yaxis: "y2", line: {color: ink, shape: "hv"}});
  if (seen(motor, "holdable_pwm")) add("holdable_pwm", {name: "PWM that can be held", yaxis: "y2", line: {color: ink, dash: "dot", shape: "hv"}});
  heatRules(motor).forEach((rule, place) => {
    add(rule.column, {name: `heat: ${rule.rule}`, yaxis: "y4", line: {color: colour(place + parts.length), width: 1.8, shape: "hv", dash: ["solid", "dash", "dot"][place % 3]}});
  });
  if (seen(motor, "time_to_limit_s")) add("time_to_limit_s", {name: "time to limit, s", yaxis: "y5", line: {color: ink, width: 1.4}});
  if (motor.curves.speed_rpm) add("speed_rpm", {name: "speed, rpm", yaxis: "y3", line: {color: ink, dash: "dash", width: 1}});
  return found;
}

// Last time, and lowest and highest temperature within a window before it, s; 0: of all.
function extent(motor, shownWindow) {
  const times = (motor.curves.pwm || [[]])[0], now = times.length ? times[times.length - 1] : 0, from = shownWindow ? now - shownWindow : -Infinity;
  let low = Infinity, high = -Infinity;
  for (const name of motor.components()) {
    for (const column of [`${name}_degC`, `${name}_model_degC`]) {
      const [x, y] = motor.curves[column] || [[], []];
      for (let k = x.length - 1; k >= 0 && x[k] >= from; --k) if (y[k] != null) { low = Math.min(low, y[k]); high = Math.max(high, y[k]); }
    }
  }
  return {first: times.length ? times[0] : 0, now, low, high};
}

// Motors that stand side by side have one scale, or their curves could not be compared.
function common(motors, shownWindow) {
  const all = motors.map((motor) => extent(motor, shownWindow)), low = Math.min(...all.map((one) => one.low)), high = Math.max(...all.map((one) => one.high));
  const first = Math.min(...all.map((one) => one.first)), now = Math.max(...all.map((one) => one.now)), room = 0.05 * Math.max(high - low, 1);
  return {x: [first, Math.max(now, first + 1)], y: low <= high ? [low - room, high + room] : null};
}

function draw(motor, page, shownWindow, scale) {
  const plot = motor.by("plot"), style = getComputedStyle(document.body), bad = style.getPropertyValue("--bad");
  const times = (motor.curves.pwm || [[]])[0], now = times.length ? times[times.length - 1] : 0, until = scale ? scale.x[1] : now, domains = panels(motor);
  const axis = {gridcolor: style.getPropertyValue("--rule"), zeroline: false, automargin: true};
  const panel = (name, title, own) => domains[name] ? {[name]: {...axis, title: {text: title}, domain: domains[name], rangemode: "tozero", ...own}} : {};
  const layout = {
    datarevision: ++motor.drawn, // the curves grow where they are: without it they would be taken for unchanged
    uirevision: `${motor.number}`, margin: {l: 50, r: 50, t: 10, b: 40}, showlegend: true, legend: {orientation: "h", yref: "container", y: 0, yanchor: "bottom"},
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: {color: style.color},
    xaxis: {...axis, title: {text: "time, s"}, anchor: "y2", ...(shownWindow ? {range: [until - shownWindow, until + 0.03 * shownWindow], uirevision: until} : scale ? {range: scale.x} : {})},
    ...panel("yaxis", "°C", {rangemode: "normal", ...(scale && scale.y ? {range: scale.y} : {})}),
    ...panel("yaxis2", "PWM"),
    yaxis3: {title: {text: "rpm"}, overlaying: "y2", side: "right", showgrid: false, zeroline: false, rangemode: "tozero", tickmode: "auto", nticks: 4},
    ...panel("yaxis4", "heat, %"),
    ...panel("yaxis5", "limit, s"),
    shapes: domains.yaxis4 ? [{type: "line", xref: "paper", x0: 0, x1: 1, yref: "y4", y0: 100, y1: 100, line: {color: bad, width: 1, dash: "dash"}}] : [], // there the alarm is raised
  };
  const panelled = String(Object.keys(domains).length), grown = plot.dataset.panels !== panelled;
  plot.dataset.panels = panelled; // more of them are higher together
  Plotly.react(plot, traces(motor, page), layout, {responsive: true, displaylogo: false});
  if (grown) Plotly.Plots.resize(plot);
  Object.assign(plot.dataset, {points: String(times.length), until: String(now)}); // what was drawn, for who looks at it from outside
}
