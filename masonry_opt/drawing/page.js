// Script of all pages. It uses ``figure``, which page_plane.js or page_space.js defines, with these members:
// - element: the element of the page that shows the figure;
// - moves(): true if the scene has a mechanism;
// - move(share): show the mechanism after a share of its full motion;
// - keyframe(motions, marks): show a state of the load history;
// - pick(joint): highlight a joint and its two blocks;
// - show(kind): show the marks of a quantity, such as "thrust";
// - near(event): return the joint at the pointer, or -1 if there is none.
const main = document.querySelector("main");
const slider = document.getElementById("moved");
const number = document.getElementById("joint");
const joints = data.joints;

// Show a quantity on the joints. Forces are shown on the scene at rest, because they act in this position.
function show(what) {
  main.dataset.show = what;
  slider.disabled = what !== "mechanism" || !figure.moves();
  slider.parentElement.classList.toggle("off", slider.disabled);
  figure.show(what);
  if (what === "history") loadHistory.moveBlocks();
  else figure.move(slider.disabled ? 0 : +slider.value);
}

// Select the button of a quantity, and show it.
function choose(what) {
  document.querySelector(`input[name=show][value=${what}]`).checked = true;
  show(what);
}

// Highlight a joint, and show its numbers in the table.
function pick(joint) {
  const first = joints.first[joint], second = joints.second[joint];
  figure.pick(joint);
  number.value = joint;
  document.getElementById("first").textContent = data.blocks[first];
  document.getElementById("second").textContent = data.blocks[second];
  for (const cell of document.querySelectorAll("[data-of]")) writeNumber(cell, joints[cell.dataset.of][joint]);
}

// Write a number into a cell of a table.
function writeNumber(cell, value) {
  cell.textContent = value === null ? "–" : String(value).replaceAll("-", "−");
}

// Select the joint at the pointer, if there is one.
function pickNear(event) {
  const nearest = figure.near(event);
  if (nearest >= 0 && String(nearest) !== number.value) pick(nearest);
}

figure.element.addEventListener("pointermove", pickNear);
figure.element.addEventListener("pointerdown", pickNear);
slider.addEventListener("input", () => figure.move(+slider.value));
loadHistory?.slider.addEventListener("input", () => {
  loadHistory.update();
  if (main.dataset.show === "history") loadHistory.moveBlocks();
  else choose("history");
});
number.addEventListener("input", () => number.value in joints.first && pick(+number.value));
number.addEventListener("focus", () => number.value in joints.first && pick(+number.value));
for (const choice of document.querySelectorAll("input[name=show]"))
  choice.addEventListener("change", () => show(choice.value));
// A browser may restore the choice of an earlier visit, so the page shows the quantity of the chosen button.
show(document.querySelector("input[name=show]:checked").value);
