// Pointer, touch and keys on the stage move the camera.
const TURN = 3.2; // Angle of a drag across the height of the image (rad).
const CLICK = 5; // Maximum movement of a click (px).
const FLY = { KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyD: [1, 0, 0], KeyA: [-1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0] };
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// Handles the input of a stage. `actions` are: camera(), which is null without control; moved(); clicked(position);
// focused(position); and drags(x, y, event), which returns whether the drag moves an object in place of the camera.
function steer(screen, actions) {
  const { stage, handle } = screen;
  const pointers = new Map(); // Last position of each pointer, and its button.
  const at = ({ pointerId, clientX, clientY }, button) => ({ pointerId, clientX, clientY, button });
  let pressed = null;

  stage.addEventListener('pointerdown', (event) => {
    if (event.target === handle) return;
    stage.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, at(event, event.button));
    pressed = pointers.size === 1 ? at(event) : null;
    stage.focus({ preventScroll: true });
  });
  stage.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    const camera = actions.camera();
    if (!before || !camera) return;
    const { height } = stage.getBoundingClientRect();
    const [x, y] = [(event.clientX - before.clientX) / height, (event.clientY - before.clientY) / height];
    const starts = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY);
    if (pointers.size === 1 && actions.drags(x, y, event)) {
      if (starts > CLICK) pressed = null;
      pointers.set(event.pointerId, at(event, before.button));
      return;
    }
    if (pointers.size === 2) {
      const [other] = [...pointers.values()].filter((of) => of.pointerId !== event.pointerId);
      const spread = (of) => Math.hypot(of.clientX - other.clientX, of.clientY - other.clientY);
      camera.dolly(Math.max(0.5, Math.min(2, spread(before) / Math.max(1, spread(event)))));
      camera.pan(-x / 2, y / 2);
    } else if (event.shiftKey || before.button === 2 || before.button === 1) {
      camera.pan(-x, y);
    } else if (event.altKey) {
      camera.look(-x * TURN * 0.5, -y * TURN * 0.5);
    } else {
      camera.orbit(-x * TURN, y * TURN);
    }
    if (starts > CLICK) pressed = null;
    pointers.set(event.pointerId, at(event, before.button));
    if (!pressed) actions.moved();
  });
  const lift = (event) => {
    pointers.delete(event.pointerId);
    if (pressed && event.type === 'pointerup') actions.clicked(screen.position(event), event);
    pressed = null;
  };
  stage.addEventListener('pointerup', lift);
  stage.addEventListener('pointercancel', lift);
  stage.addEventListener('contextmenu', (event) => event.preventDefault());
  stage.addEventListener('dblclick', (event) => actions.focused(screen.position(event)));
  stage.addEventListener(
    'wheel',
    (event) => {
      const camera = actions.camera();
      if (!camera) return;
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      camera.dolly(Math.exp((event.deltaY * lines) / 600));
      actions.moved();
    },
    { passive: false },
  );

  // Fly while a key is held; orbit by arrows.
  const held = new Set();
  let last = 0;
  function fly(now) {
    if (!held.size) return;
    const camera = actions.camera();
    const seconds = Math.min(0.1, (now - last) / 1000);
    last = now;
    if (camera) {
      const { forward, right, up } = camera.axes();
      const speed = camera.distance * seconds * (held.has('shift') ? 3 : 1);
      for (const code of held) {
        const [x, y, z] = FLY[code] || [0, 0, 0];
        camera.move(add(add(right.map((value) => value * x * speed), up, y * speed), forward, z * speed));
        const [turn, rise] = ARROWS[code] || [0, 0];
        camera.orbit(turn * seconds * 1.5, -rise * seconds * 1.5);
      }
      actions.moved();
    }
    requestAnimationFrame(fly);
  }
  stage.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || (!FLY[event.code] && !ARROWS[event.code])) return;
    event.preventDefault();
    const begins = !held.size;
    held.add(event.code);
    if (event.shiftKey) held.add('shift');
    if (begins) {
      last = performance.now();
      requestAnimationFrame(fly);
    }
  });
  const release = (event) => {
    held.delete(event.code);
    if (!event.shiftKey) held.delete('shift');
    if ([...held].every((code) => code === 'shift')) held.clear();
  };
  stage.addEventListener('keyup', release);
  stage.addEventListener('blur', () => held.clear());

  // Move the wipe.
  const drag = (event) => {
    if (handle.hasPointerCapture(event.pointerId)) screen.wipeTo(screen.position(event)[0]);
  };
  handle.addEventListener('pointerdown', (event) => handle.setPointerCapture(event.pointerId));
  handle.addEventListener('pointermove', drag);
  handle.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    screen.wipeTo(screen.at + step);
  });
}
