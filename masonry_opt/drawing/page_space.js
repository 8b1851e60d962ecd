"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
// Figure of a scene in space, drawn by three.js. All elements are triangles and lines. Their corners move on straight
// lines, as in a small motion.
const figure = (() => {
  const {surface, motions: ofMechanism, layers, outlines, view, size} = data.figure, joints = data.joints;
  let motions = ofMechanism; // motions of blocks in the present view: the mechanism, or a state of the load history
  const element = document.querySelector(".solids"), glass = document.getElementById("glass");
  const triad = [...element.querySelectorAll(".axes g")];
  const standing = {element, moves: () => ofMechanism.flat().some(Boolean), move() {}, keyframe() {}, pick() {}, show() {}, near: () => -1};
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({preserveDrawingBuffer: true}); // tests and printing read the drawn pixels
  } catch {
    element.classList.add("still"); // without WebGL the page shows a fixed picture
    return standing;
  }
  const scene = new THREE.Scene(), camera = new THREE.OrthographicCamera();
  let moving = []; // coordinates that move: attribute, values at rest, and displacements of the full motion
  const target = new THREE.Vector3(...data.figure.middle);
  let [azimuth, elevation] = view.map(THREE.MathUtils.degToRad);
  let half = 1; // half the height of the visible area, in units of the figure
  let share = 0, what = "mechanism";
  let chosen = -1; // number of the selected joint, -1 if no joint is selected
  renderer.setClearColor(0xffffff);
  camera.up.set(0, 0, 1);
  element.prepend(renderer.domElement);

  // Return the displacement of a point r in a full motion (v, w), which is v + w × r.
  const stepOf = ([x, y, z], [vx, vy, vz, wx, wy, wz]) =>
    [vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x];
  const plus = (one, other) => one.map((value, axis) => value + other[axis]);
  const times = (vector, factor) => vector.map((value) => value * factor);
  const point = (list, at) => list.slice(3 * at, 3 * at + 3);
  const still = [0, 0, 0, 0, 0, 0];

  // Return a geometry of three.js, and register its coordinates if they move.
  function geometry(rest, step, index) {
    const made = new THREE.BufferGeometry(), at = new THREE.Float32BufferAttribute(rest, 3);
    made.setAttribute("position", at);
    if (index) made.setIndex(index);
    made.boundingSphere = new THREE.Sphere(target, 10 * size);
    if (step.some(Boolean)) moving.push({at, rest: Float32Array.from(rest), step: Float32Array.from(step), made});
    return made;
  }

  // Return the colours of the corners of triangles, shaded by the direction of each triangle.
  function coloured(triangles, factor) {
    const colours = new Float32Array(9 * triangles.length), own = new THREE.Color();
    const side = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    triangles.forEach((corners, number) => {
      corners.forEach((corner, place) => side[place].fromArray(surface.points, 3 * corner));
      const normal = side[1].sub(side[0]).cross(side[2].sub(side[0])).normalize();
      // Light comes from above and a little from one side, so that neighbouring sides of a block differ.
      const light = 0.83 + 0.14 * normal.z + 0.06 * normal.x - 0.04 * normal.y;
      own.set(factor(surface.of[corners[0]])).multiplyScalar(light);
      for (let place = 0; place < 3; place++) own.toArray(colours, 9 * number + 3 * place);
    });
    return colours;
  }

  const threes = [];
  for (let at = 0; at < surface.triangles.length; at += 3) threes.push(surface.triangles.slice(at, at + 3));
  const corner = (at) => point(surface.points, at);
  const stepAt = (at) => stepOf(corner(at), motions[surface.of[at]]);
  const solid = geometry(threes.flat().flatMap(corner), threes.flat().flatMap(stepAt));
  const usual = coloured(threes, (block) => data.fixed.includes(block) ? data.figure.fixed : data.figure.block);
  solid.setAttribute("color", new THREE.Float32BufferAttribute(usual, 3));
  const clay = new THREE.MeshBasicMaterial({vertexColors: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
  const mesh = new THREE.Mesh(solid, clay);
  scene.add(mesh);
  const inks = [0x333333, 0x8a8a8a].map((color) => new THREE.LineBasicMaterial({color}));
  const lines = (made, ink) => scene.add(new THREE.LineSegments(made, ink));
  const edges = geometry(surface.edges.flatMap(corner), surface.edges.flatMap(stepAt));
  lines(edges, inks[0]);
  lines(geometry(surface.hatching, surface.hatching.map(() => 0)), inks[1]);

  // ``around`` are the indices of the triangles of a four-sided bar. ``bar`` returns its eight corners ``at``, each with
  // the end of the bar ``of`` whose motion it takes.
  const around = [0, 2, 4, 6].flatMap((a) => { const b = (a + 2) % 8; return [a, b, b + 1, a, b + 1, a + 1]; });
  function bar(from, to, radius) {
    const along = new THREE.Vector3(...to).sub(new THREE.Vector3(...from)).normalize();
    const across = new THREE.Vector3(...(Math.abs(along.z) < 0.9 ? [0, 0, 1] : [1, 0, 0])).cross(along).normalize();
    const other = along.clone().cross(across);
    const rim = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) =>
      across.clone().multiplyScalar(0.7 * a * radius).addScaledVector(other, 0.7 * b * radius).toArray());
    return rim.flatMap((off) => [{at: plus(from, off), of: from}, {at: plus(to, off), of: to}]);
  }
  const ball = new THREE.IcosahedronGeometry(1, 1), cube = new THREE.BoxGeometry(1.5, 1.5, 1.5).toNonIndexed();
  // Return the corners of a ball or cube around a middle.
  const solidAt = (shape, middle, radius) => {
    const all = [...shape.attributes.position.array];
    return all.flatMap((_, at) => at % 3 ? [] : [{at: plus(middle, times(all.slice(at, at + 3), radius)), of: middle}]);
  };
  // Return the corners of the head of an arrow, as triangles.
  function head(from, to, radius) {
    const along = plus(to, times(from, -1)), rim = bar(from, to, 3.2 * radius).filter((_, at) => at % 2 === 0);
    const base = plus(from, times(along, 0.65)), ring = rim.map(({at}) => plus(at, times(along, 0.65)));
    return ring.flatMap((one, at) => [one, ring[(at + 1) % 4], to, ring[(at + 1) % 4], one, base].map((place) => ({at: place, of: to})));
  }

  // Return the dashes of a line as pairs of ends.
  function dashed(from, to, [dash, gap], radius) {
    const run = plus(to, times(from, -1)), long = Math.hypot(...run), period = 2 * (dash + gap) * radius;
    const count = Math.max(1, Math.round(long / period)), pieces = [];
    for (let piece = 0; piece < count; piece++)
      pieces.push([piece, piece + dash / (dash + gap)].map((part) => plus(from, times(run, part / count))));
    return pieces;
  }

  // Return one mesh of all marks of a kind. ``motion`` are the indices of their motions in a table; null if no mark moves.
  function marked({shape, points, motion, radius, colour, dashes, through}, table = data.figure.table) {
    const rest = [], step = [], index = [], ends = ["line", "arrow", "bar"].includes(shape) ? 2 : 1;
    const add = (corners, motionOf, joined) => {
      const first = rest.length / 3;
      for (const {at, of} of corners) rest.push(...at), step.push(...stepOf(of, motionOf));
      index.push(...joined.map((number) => first + number));
    };
    for (let mark = 0; mark < points.length / 3 / ends; mark++) {
      const from = point(points, ends * mark), to = point(points, ends * mark + ends - 1);
      const motionOf = motion ? table[motion[mark]] : still;
      const sequence = (corners) => add(corners, motionOf, corners.map((_, at) => at));
      if (shape === "line")
        for (const piece of dashes.length ? dashed(from, to, dashes, radius) : [[from, to]]) add(bar(...piece, radius), motionOf, around);
      else if (shape === "arrow") {
        add(bar(from, plus(from, times(plus(to, times(from, -1)), 0.7)), radius), motionOf, around);
        sequence(head(from, to, radius));
      } else sequence(solidAt(shape === "dot" || shape === "point" ? ball : cube, from, radius));
    }
    const material = new THREE.MeshBasicMaterial({color: colour, side: THREE.DoubleSide, depthTest: !through});
    const made = new THREE.Mesh(geometry(rest, step, index), material);
    made.renderOrder = through ? 2 : 1;
    return made;
  }

  const groups = {};
  for (const [name, marks] of Object.entries(layers)) {
    scene.add(groups[name] = new THREE.Group());
    for (const each of marks) groups[name].add(marked(each));
  }
  const picked = new THREE.Group(), yielded = new THREE.Group();
  scene.add(picked, yielded);

  const midway = (joint) => times(plus(motions[joints.first[joint]], motions[joints.second[joint]]), 0.5);
  const sides = joints.first.map(() => []); // lines of each joint's outline, as pairs of ends
  outlines.of.forEach((joint, line) => sides[joint].push([point(outlines.points, 2 * line), point(outlines.points, 2 * line + 1)]));
  const ofBlock = new Map(data.blocks.map((_, block) => [block, []]));
  joints.first.forEach((first, joint) => [first, joints.second[joint]].forEach((block) => ofBlock.get(block).push(joint)));

  // While the figure moves it is drawn with the pixels of the window. At rest it is drawn with more pixels, for smooth
  // edges. Smooth edges in every frame would take three times as long if the browser draws without a graphics card.
  const coarse = Math.min(window.devicePixelRatio, 2);
  let fine = 0; // timer of the drawing with more pixels
  function render() {
    draw(coarse);
    clearTimeout(fine);
    fine = setTimeout(() => draw(2), 150);
  }

  // Draw the scene and the triad of axes with a number of pixels per pixel of the page.
  function draw(ratio) {
    if (renderer.getPixelRatio() !== ratio) renderer.setPixelRatio(ratio);
    camera.position.set(Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation));
    camera.position.multiplyScalar(10 * size).add(target);
    camera.lookAt(target);
    camera.updateMatrixWorld();
    const wide = (half * element.clientWidth) / element.clientHeight;
    Object.assign(camera, {left: -wide, right: wide, top: half, bottom: -half, near: 0, far: 20 * size});
    camera.updateProjectionMatrix();
    renderer.render(scene, camera);
    element.dataset.half = half;
    const turn = new THREE.Matrix4().copy(camera.matrixWorld).invert();
    triad.forEach((group, axis) => {
      const [x, y] = [turn.elements[4 * axis], -turn.elements[4 * axis + 1]];
      group.querySelector("path").setAttribute("d", `M0 0L${20 * x} ${20 * y}`);
      group.querySelector("text").setAttribute("x", 27 * x);
      group.querySelector("text").setAttribute("y", 27 * y);
    });
  }

  // Move registered coordinates by the share of the full motion.
  function place(selected) {
    for (const {at, rest, step} of selected) {
      const now = at.array;
      for (let i = 0; i < now.length; i++) now[i] = rest[i] + share * step[i];
      at.needsUpdate = true;
    }
  }

  // Show the mechanism after a share of its full motion.
  function move(value) {
    const returns = motions !== ofMechanism;
    motions = ofMechanism;
    share = value;
    if (returns) {
      removeMeshes(yielded);
      outline();
    }
    place(moving);
    render();
  }

  // Show a state of the load history. Blocks move, but loads and other marks on them do not.
  function keyframe(now, marks) {
    move(0);
    motions = now;
    share = 1;
    for (const [made, corners] of [[solid, threes.flat()], [edges, surface.edges]]) {
      const at = made.attributes.position;
      corners.forEach((number, place) => at.set(plus(corner(number), stepAt(number)), 3 * place));
      at.needsUpdate = true;
    }
    for (const {colour, width, dashes, joints: which} of marks) {
      const points = which.flatMap((joint) => [joints.first[joint], joints.second[joint]].flatMap((block) =>
        sides[joint].flat().flatMap((end) => plus(end, stepOf(end, now[block])))));
      if (points.length) yielded.add(marked({shape: "line", points, motion: null, radius: (width * data.figure.radius) / 3, colour, dashes, through: false}));
    }
    outline();
    render();
  }

  // Show the marks of a quantity. Blocks are transparent for the thrust, or if the reader asks for it.
  function show(kind) {
    what = kind;
    for (const [name, group] of Object.entries(groups)) group.visible = name === "loads" || name === kind;
    const clear = glass.checked || kind === "thrust";
    Object.assign(clay, {transparent: clear, opacity: clear ? 0.25 : 1, depthWrite: !clear});
    for (const ink of inks) Object.assign(ink, {transparent: clear, opacity: clear ? 0.3 : 1, needsUpdate: true});
    clay.needsUpdate = true;
    render();
  }

  // Remove all meshes of a group.
  function removeMeshes(group) {
    for (const made of group.children) {
      moving = moving.filter((each) => each.made !== made.geometry);
      made.geometry.dispose();
    }
    group.clear();
  }

  // Highlight a joint and its first block.
  function pick(joint) {
    chosen = joint;
    outline();
    paint(joints.first[joint]);
    render();
  }

  // Draw the outline of the selected joint, which moves with the mean motion of its two blocks in the present view.
  function outline() {
    removeMeshes(picked);
    if (chosen < 0) return;
    const points = sides[chosen].flat(2), motion = sides[chosen].map(() => 0), table = [midway(chosen)];
    const radius = data.figure.radius;
    for (const [colour, factor] of [[0x000000, 1.5], [0xcc79a7, 1]])
      picked.add(marked({shape: "line", points, motion, radius: factor * radius, colour, dashes: [], through: true}, table));
    picked.children[0].renderOrder = 3;
    picked.children[1].renderOrder = 4;
    const drawn = picked.children.map((made) => made.geometry);
    place(moving.filter(({made}) => drawn.includes(made)));
  }

  // Paint one block blue, which is the first block of the selected joint, and all others in their usual colours.
  function paint(block) {
    const at = solid.attributes.color, own = new THREE.Color(0xbbd7ea);
    at.array.set(usual);
    threes.forEach((corners, number) => {
      if (surface.of[corners[0]] === block)
        for (let place = 3 * number; place < 3 * number + 3; place++)
          at.setXYZ(place, ...own.toArray().map((part, axis) => Math.min(1, part * usual[3 * place + axis] * 1.12)));
    });
    at.needsUpdate = true;
  }

  // Return the intersection of the blocks with the ray through the pointer, nearest to the eye.
  const ray = new THREE.Raycaster();
  function hitAt(event) {
    const frame = element.getBoundingClientRect();
    const pointer = {x: (2 * (event.clientX - frame.left)) / frame.width - 1, y: 1 - (2 * (event.clientY - frame.top)) / frame.height};
    ray.setFromCamera(pointer, camera);
    return ray.intersectObject(mesh)[0];
  }

  // Return the joint nearest to the pointer, among those of the block at the pointer, or -1 if none is within 24 pixels.
  function near(event) {
    if (pointers.size) return -1;
    const hit = hitAt(event);
    if (!hit) return -1;
    const block = surface.of[threes[hit.faceIndex][0]];
    showBlock(block);
    const line = new THREE.Line3(), foot = new THREE.Vector3();
    let nearest = -1, least = (24 * 2 * half) / element.clientHeight;
    for (const joint of ofBlock.get(block))
      for (const [from, to] of sides[joint]) {
        const motion = motions[block];
        line.start.fromArray(plus(from, times(stepOf(from, motion), share)));
        line.end.fromArray(plus(to, times(stepOf(to, motion), share)));
        const far = line.closestPointToPoint(hit.point, true, foot).distanceTo(hit.point);
        if (far < least) [nearest, least] = [joint, far];
      }
    return nearest;
  }

  // Show the name and the rates of motion of a block.
  function showBlock(block) {
    document.getElementById("block").textContent = data.blocks[block];
    for (const cell of document.querySelectorAll("[data-rate]")) {
      const rates = data.rates[block];
      cell.textContent = rates ? rates[cell.dataset.rate].map((value) => String(value).replaceAll("-", "−")).join(", ") : "–";
    }
  }

  const fit = () => renderer.setSize(element.clientWidth, element.clientHeight);

  // Turn the view to an azimuth and an elevation, in radians.
  function look(toAzimuth, toElevation) {
    [azimuth, elevation] = [toAzimuth, Math.max(-1.57, Math.min(1.57, toElevation))];
    render();
  }

  const zoom = (factor) => { half = Math.max(size / 100, Math.min(5 * size, half * factor)); render(); };
  // Shift the scene by a number of pixels of the page.
  function shift(right, up) {
    const unit = (2 * half) / element.clientHeight;
    for (const [axis, by] of [[0, -right * unit], [1, up * unit]])
      target.addScaledVector(new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, axis), by);
    render();
  }

  // The mouse or one finger turns the scene. The right button or the shift key shifts it. Two fingers zoom and shift it.
  const pointers = new Map();
  const canvas = renderer.domElement;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const right = event.clientX - before.clientX, down = event.clientY - before.clientY;
    if (pointers.size === 2) {
      const [other] = [...pointers.values()].filter((each) => each.pointerId !== event.pointerId);
      const apart = (each) => Math.hypot(each.clientX - other.clientX, each.clientY - other.clientY) || 1;
      zoom(apart(before) / apart(event));
      shift(right / 2, down / 2);
    } else if (event.shiftKey || event.buttons & 2) shift(right, down);
    else look(azimuth - right / 150, elevation + down / 150);
    pointers.set(event.pointerId, event);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(1.0015 ** event.deltaY); }, {passive: false});
  element.addEventListener("keydown", (event) => {
    const turns = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1]}[event.key];
    if (turns) look(azimuth + turns[0], elevation + turns[1]);
    else if ("+-".includes(event.key)) zoom(event.key === "+" ? 0.9 : 1.1);
    else return;
    event.preventDefault();
  });
  for (const button of document.querySelectorAll("[data-view]"))
    button.addEventListener("click", () => {
      target.set(...data.figure.middle);
      look(...button.dataset.view.split(" ").map((angle) => THREE.MathUtils.degToRad(+angle)));
      half = smallestHalf();
      render();
    });
  glass.addEventListener("change", () => show(what));

  // Points that the first view must contain: corners of blocks at rest and moved, and ends of loads.
  const everything = surface.of.flatMap((_, at) => [corner(at), plus(corner(at), stepAt(at))]);
  if (data.history) {
    motions = motionsAt(data.history.motions.length - 1);
    surface.of.forEach((_, at) => everything.push(plus(corner(at), stepAt(at))));
    motions = ofMechanism;
  }
  for (const {points} of layers.loads) for (let at = 0; at < points.length; at += 3) everything.push(points.slice(at, at + 3));

  // Return half the smallest height of the visible area that contains all these points in the present direction.
  function smallestHalf() {
    render();
    const turn = new THREE.Matrix4().extractRotation(camera.matrixWorld).invert(), turned = new THREE.Vector3();
    const slope = element.clientHeight / element.clientWidth;
    let most = 0;
    for (const shown of everything) {
      const {x, y} = turned.fromArray(shown).sub(target).applyMatrix4(turn);
      most = Math.max(most, Math.abs(y), slope * Math.abs(x));
    }
    return 1.06 * most;
  }

  fit();
  half = smallestHalf();
  new ResizeObserver(() => { fit(); half = Math.max(half, smallestHalf()); render(); }).observe(element);
  return {...standing, move, keyframe, pick, show, near};
})();
