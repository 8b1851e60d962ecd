// What all pages do: the figure, made before, has an element, moves(), move(share), pick(joint), show(what), and
// near(event), the joint that an event points at or -1, and keyframe(motions, marks), a state of the load history.
const main = document.querySelector("main");
const slider = document.getElementById("moved");
const number = document.getElementById("joint");
const joints = data.joints;

// Forces act on the scene at rest.
function show(what) {
  main.dataset.show = what;
  slider.disabled = what !== "mechanism" || !figure.moves();
  slider.parentElement.classList.toggle("off", slider.disabled);
  figure.show(what);
  if (what === "history") loadHistory.place();
  else figure.move(slider.disabled ? 0 : +slider.value);
}

function choose(what) {
  document.querySelector(`input[name=show][value=${what}]`).checked = true;
  show(what);
}

function pick(joint) {
  const first = joints.first[joint], second = joints.second[joint];
  figure.pick(joint);
  number.value = joint;
  document.getElementById("first").textContent = data.blocks[first];
  document.getElementById("second").textContent = data.blocks[second];
  for (const cell of document.querySelectorAll("[data-of]")) tell(cell, joints[cell.dataset.of][joint]);
}

function tell(cell, value) {
  cell.textContent = value === null ? "–" : String(value).replaceAll("-", "−");
}

function pickNear(event) {
  const nearest = figure.near(event);
  if (nearest >= 0 && String(nearest) !== number.value) pick(nearest);
}

figure.element.addEventListener("pointermove", pickNear);
figure.element.addEventListener("pointerdown", pickNear);
slider.addEventListener("input", () => figure.move(+slider.value));
loadHistory?.slider.addEventListener("input", () => {
  loadHistory.tell();
  if (main.dataset.show === "history") loadHistory.place();
  else choose("history");
});
number.addEventListener("input", () => number.value in joints.first && pick(+number.value));
number.addEventListener("focus", () => number.value in joints.first && pick(+number.value));
for (const choice of document.querySelectorAll("input[name=show]"))
  choice.addEventListener("change", () => show(choice.value));
// A browser may bring back what was chosen before the page was loaded again.
show(document.querySelector("input[name=show]:checked").value);
