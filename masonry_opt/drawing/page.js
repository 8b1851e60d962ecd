"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const main = document.querySelector("main");
const picture = document.querySelector("svg.picture");
const slider = document.getElementById("moved");
const number = document.getElementById("joint");
const motionOf = (element) => (element.dataset.motion || "0 0 0").split(" ").map(Number);
const moving = [...picture.querySelectorAll("[data-motion]")].map((element) => [element, motionOf(element)]);
const blocks = [...picture.querySelectorAll(".blocks path")]; // in the order of data.blocks
const motions = blocks.map((path) => motionOf(path.parentElement));
const joints = data.joints;
const picked = document.createElementNS(picture.namespaceURI, "g");
let share = 0; // of the mechanism that is shown
let shown = []; // the two blocks of the joint that is picked

// The point (x, y) moves by share times (vx - omega y, vy + omega x).
const matrix = ([vx, vy, omega]) =>
  `matrix(1 ${share * omega} ${-share * omega} 1 ${share * vx} ${share * vy})`;

// A joint lies midway between its two blocks.
const motionsOfJoints = joints.first.map((first, joint) =>
  motions[first].map((value, part) => (value + motions[joints.second[joint]][part]) / 2));

function move(value) {
  share = value;
  for (const [element, motion] of moving) element.setAttribute("transform", matrix(motion));
  if (picked.hasChildNodes()) picked.setAttribute("transform", matrix(motionsOfJoints[number.value]));
}

// Forces act on the scene at rest.
function show(what) {
  main.dataset.show = what;
  slider.disabled = what !== "mechanism" || !moving.length;
  slider.parentElement.classList.toggle("off", slider.disabled);
  move(slider.disabled ? 0 : +slider.value);
}

function pick(joint) {
  const first = joints.first[joint], second = joints.second[joint];
  for (const path of shown) path.removeAttribute("class");
  shown = [blocks[first], blocks[second]];
  blocks[first].setAttribute("class", "first");
  blocks[second].setAttribute("class", "second");
  const line = `M${joints.x[joint]} ${joints.y[joint]}l${joints.dx[joint]} ${joints.dy[joint]}`;
  picked.innerHTML = `<path class="under" d="${line}"/><path class="over" d="${line}"/>`;
  picked.setAttribute("transform", matrix(motionsOfJoints[joint]));
  number.value = joint;
  document.getElementById("first").textContent = data.blocks[first];
  document.getElementById("second").textContent = data.blocks[second];
  for (const cell of document.querySelectorAll("[data-of]")) {
    const value = joints[cell.dataset.of][joint];
    cell.textContent = value === null ? "–" : String(value).replace("-", "−");
  }
}

// The joint next to the pointer, if any is within some 24 pixels.
function pickNear(event) {
  const place = picture.getScreenCTM();
  const pointer = new DOMPoint(event.clientX, event.clientY).matrixTransform(place.inverse());
  let nearest = -1, least = (24 / place.a) ** 2;
  for (let joint = 0; joint < joints.first.length; joint++) {
    const [vx, vy, omega] = motionsOfJoints[joint];
    const x = joints.x[joint], y = joints.y[joint], dx = joints.dx[joint], dy = joints.dy[joint];
    const toX = pointer.x - x - share * (vx - omega * y), toY = pointer.y - y - share * (vy + omega * x);
    const along = Math.min(1, Math.max(0, (toX * dx + toY * dy) / (dx * dx + dy * dy || 1)));
    const distance = (toX - along * dx) ** 2 + (toY - along * dy) ** 2;
    if (distance < least) [nearest, least] = [joint, distance];
  }
  if (nearest >= 0 && String(nearest) !== number.value) pick(nearest);
}

picked.setAttribute("class", "picked");
picture.insertBefore(picked, picture.querySelector(".layer")); // marks stay on top
picture.addEventListener("pointermove", pickNear);
picture.addEventListener("pointerdown", pickNear);
slider.addEventListener("input", () => move(+slider.value));
number.addEventListener("input", () => number.value in joints.first && pick(+number.value));
number.addEventListener("focus", () => number.value in joints.first && pick(+number.value));
for (const choice of document.querySelectorAll("input[name=show]"))
  choice.addEventListener("change", () => show(choice.value));
// A browser may bring back what was chosen before the page was loaded again.
show(document.querySelector("input[name=show]:checked").value);
