"use strict";
// The page: its motors, the time that all of them show, and when they are drawn.

const DRAW_MS = 500;
const motors = [];
let about = null, shownWindow = 0;

function drawAll() {
  if (document.hidden || !about || !motors.some((motor) => motor.dirty)) return;
  const scale = motors.length > 1 ? common(motors, shownWindow) : null; // one that grows moves the other's axes, too
  for (const motor of motors) {
    if (!motor.dirty && !scale) continue;
    motor.dirty = false;
    draw(motor, about, shownWindow, scale);
  }
}

async function begin() {
  about = await (await fetch("about")).json();
  about.motors.forEach((told, k) => motors.push(new Motor(k + 1, told)));
  document.title = `${about.motors.map((told) => told.name).join(" beside ")}: gen live`;
  document.body.classList.toggle("two", motors.length > 1);
  for (const motor of motors) motor.build(motors.length === 1);
  for (const button of document.querySelectorAll("#windows button")) {
    button.addEventListener("click", () => {
      shownWindow = Number(button.dataset.window);
      for (const other of document.querySelectorAll("#windows button")) other.setAttribute("aria-pressed", String(other === button));
      for (const motor of motors) motor.dirty = true;
      drawAll();
    });
  }
  setInterval(drawAll, DRAW_MS);
  await Promise.all(motors.map((motor) => motor.refresh()));
}

begin();
