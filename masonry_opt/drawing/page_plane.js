"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
// A scene in the plane: an SVG whose elements have motions.
const figure = (() => {
  const picture = document.querySelector("svg.picture"), joints = data.joints;
  const motionOf = (element) => (element.dataset.motion || "0 0 0").split(" ").map(Number);
  const moving = [...picture.querySelectorAll("[data-motion]")].map((element) => [element, motionOf(element)]);
  const blocks = [...picture.querySelectorAll(".blocks path")]; // in the order of data.blocks
  const ofMechanism = blocks.map((path) => motionOf(path.parentElement));
  let motions = ofMechanism; // of what is shown, the mechanism or a state of the load history
  const [picked, yielded] = ["picked", "yielded"].map((name) => {
    const made = document.createElementNS(picture.namespaceURI, "g");
    made.setAttribute("class", name);
    return made;
  });
  const lineOf = (joint) => `M${joints.x[joint]} ${joints.y[joint]}l${joints.dx[joint]} ${joints.dy[joint]}`;
  let share = 0; // of the mechanism that is shown
  let shown = []; // the two blocks of the joint that is picked
  let chosen = -1; // that joint

  // The point (x, y) moves by share times (vx - omega y, vy + omega x).
  const matrix = ([vx, vy, omega]) =>
    `matrix(1 ${share * omega} ${-share * omega} 1 ${share * vx} ${share * vy})`;

  // A joint lies midway between its two blocks.
  const midway = (joint) =>
    motions[joints.first[joint]].map((value, part) => (value + motions[joints.second[joint]][part]) / 2);
  let motionsOfJoints = joints.first.map((_, joint) => midway(joint));

  function turnTo(now) {
    if (motions === now) return;
    motions = now;
    motionsOfJoints = joints.first.map((_, joint) => midway(joint));
  }

  // Blocks move one by one, and what they carry stays.
  function keyframe(now, marks) {
    move(0);
    turnTo(now);
    share = 1;
    blocks.forEach((path, block) => path.setAttribute("transform", matrix(now[block])));
    yielded.innerHTML = marks.map(({colour, width, dashes, joints}) => {
      const lines = joints.map((joint) => `<path d="${lineOf(joint)}" transform="${matrix(motionsOfJoints[joint])}"/>`);
      const gaps = dashes.map((dash) => 1.5 * width * dash).join(" ");
      return `<g stroke="${colour}" stroke-width="${1.5 * width}" stroke-dasharray="${gaps}">${lines.join("")}</g>`;
    }).join("");
    if (chosen >= 0) picked.setAttribute("transform", matrix(motionsOfJoints[chosen]));
  }

  function move(value) {
    if (motions !== ofMechanism) for (const path of blocks) path.removeAttribute("transform");
    turnTo(ofMechanism);
    yielded.innerHTML = "";
    share = value;
    for (const [element, motion] of moving) element.setAttribute("transform", matrix(motion));
    if (chosen >= 0) picked.setAttribute("transform", matrix(motionsOfJoints[chosen]));
  }

  function pick(joint) {
    chosen = joint;
    const first = joints.first[joint], second = joints.second[joint];
    for (const path of shown) path.removeAttribute("class");
    shown = [blocks[first], blocks[second]];
    blocks[first].setAttribute("class", "first");
    blocks[second].setAttribute("class", "second");
    const line = lineOf(joint);
    picked.innerHTML = `<path class="under" d="${line}"/><path class="over" d="${line}"/>`;
    picked.setAttribute("transform", matrix(motionsOfJoints[joint]));
  }

  // The joint next to the pointer, if any is within some 24 pixels.
  function near(event) {
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
    return nearest;
  }

  const first = picture.querySelector(".layer"); // marks stay on top
  for (const each of [picked, yielded]) picture.insertBefore(each, first);
  return {element: picture, moves: () => moving.length > 0, move, keyframe, pick, near, show() {}};
})();
