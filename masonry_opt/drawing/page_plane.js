"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
// Figure of a scene in the plane: an SVG picture whose elements carry their motions as attributes.
const figure = (() => {
  const picture = document.querySelector("svg.picture"), joints = data.joints;
  const motionOf = (element) => (element.dataset.motion || "0 0 0").split(" ").map(Number);
  const moving = [...picture.querySelectorAll("[data-motion]")].map((element) => [element, motionOf(element)]);
  const blocks = [...picture.querySelectorAll(".blocks path")]; // in the order of data.blocks
  const ofMechanism = blocks.map((path) => motionOf(path.parentElement));
  let motions = ofMechanism; // motions of blocks in the present view: the mechanism, or a state of the load history
  const [picked, yielded] = ["picked", "yielded"].map((name) => {
    const made = document.createElementNS(picture.namespaceURI, "g");
    made.setAttribute("class", name);
    return made;
  });
  const lineOf = (joint) => `M${joints.x[joint]} ${joints.y[joint]}l${joints.dx[joint]} ${joints.dy[joint]}`;
  let share = 0; // share of the full motions that is shown
  let highlighted = []; // paths of the two blocks of the selected joint
  let chosen = -1; // number of the selected joint, -1 if no joint is selected

  // Return the transform of an element. A point (x, y) is displaced by share times (vx - omega y, vy + omega x).
  const matrix = ([vx, vy, omega]) =>
    `matrix(1 ${share * omega} ${-share * omega} 1 ${share * vx} ${share * vy})`;

  // Return the motion of a joint, which is the mean of the motions of its two blocks.
  const midway = (joint) =>
    motions[joints.first[joint]].map((value, part) => (value + motions[joints.second[joint]][part]) / 2);
  let motionsOfJoints = joints.first.map((_, joint) => midway(joint));

  // Use other motions of blocks, and compute those of joints.
  function useMotions(now) {
    if (motions === now) return;
    motions = now;
    motionsOfJoints = joints.first.map((_, joint) => midway(joint));
  }

  // Show a state of the load history. Blocks move, but loads and other marks on them do not.
  function keyframe(now, marks) {
    move(0);
    useMotions(now);
    share = 1;
    blocks.forEach((path, block) => path.setAttribute("transform", matrix(now[block])));
    yielded.innerHTML = marks.map(({colour, width, dashes, joints}) => {
      const lines = joints.map((joint) => `<path d="${lineOf(joint)}" transform="${matrix(motionsOfJoints[joint])}"/>`);
      const gaps = dashes.map((dash) => 1.5 * width * dash).join(" ");
      return `<g stroke="${colour}" stroke-width="${1.5 * width}" stroke-dasharray="${gaps}">${lines.join("")}</g>`;
    }).join("");
    if (chosen >= 0) picked.setAttribute("transform", matrix(motionsOfJoints[chosen]));
  }

  // Show the mechanism after a share of its full motion.
  function move(value) {
    if (motions !== ofMechanism) for (const path of blocks) path.removeAttribute("transform");
    useMotions(ofMechanism);
    yielded.innerHTML = "";
    share = value;
    for (const [element, motion] of moving) element.setAttribute("transform", matrix(motion));
    if (chosen >= 0) picked.setAttribute("transform", matrix(motionsOfJoints[chosen]));
  }

  // Highlight a joint and its two blocks.
  function pick(joint) {
    chosen = joint;
    const first = joints.first[joint], second = joints.second[joint];
    for (const path of highlighted) path.removeAttribute("class");
    highlighted = [blocks[first], blocks[second]];
    blocks[first].setAttribute("class", "first");
    blocks[second].setAttribute("class", "second");
    const line = lineOf(joint);
    picked.innerHTML = `<path class="under" d="${line}"/><path class="over" d="${line}"/>`;
    picked.setAttribute("transform", matrix(motionsOfJoints[joint]));
  }

  // Return the joint nearest to the pointer, or -1 if none is within 24 pixels.
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

  const first = picture.querySelector(".layer"); // marks of the layers are drawn over the highlights
  for (const each of [picked, yielded]) picture.insertBefore(each, first);
  return {element: picture, moves: () => moving.length > 0, move, keyframe, pick, near, show() {}};
})();
