// State of the page, and the actions on the stage.
const page = JSON.parse(document.body.dataset.page);
const find = (id) => document.getElementById(id);
const all = (selector) => [...document.querySelectorAll(selector)];
const token = new URLSearchParams(location.search).get('token');
const MEMORY = `caustics-view ${page.scene}`;

const screen = new Screen(find('stage'));
const inspector = new Inspector(find('overlay'));
let socket = null;
let status = null;
let camera = null;
let hasControl = false;
// Requests of this page by what they set, to be repeated when the program was started anew.
let requests = {};

function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

// Sends a request that the next run of the program gets too.
function request(key, message) {
  requests[key] = message;
  try {
    localStorage.setItem(MEMORY, JSON.stringify({ run: page.run, requests }));
  } catch {
    // The browser stores nothing.
  }
  send(message);
}

function notice(text, lasts = 6000) {
  const node = find('notice');
  node.textContent = text;
  node.hidden = !text;
  clearTimeout(notice.timer);
  if (text && lasts) notice.timer = setTimeout(() => notice(''), lasts);
}

// Makes a function that runs an action at most once a frame of the display.
function oncePerFrame(action) {
  const run = () => {
    if (run.isPending) return;
    run.isPending = true;
    requestAnimationFrame(() => {
      run.isPending = false;
      action();
    });
  };
  run.isPending = false;
  return run;
}

const sendCamera = oncePerFrame(() => {
  if (!camera) return;
  // Round to the digits of a single, which keeps commands short.
  const round = (value) => Number(value.toPrecision(8));
  const [from, look_at] = [camera.from, camera.lookAt].map((position) => position.map(round));
  request('look', { do: 'look', from, look_at, fov: round(camera.fov), at: performance.now() });
  find('fov').value = camera.fov.toFixed(1);
  find('camera').value = '';
  drawOverlays();
});

// Chosen object, and whether drags move it.
let chosen = null;
let dragsChosen = false;

// Draws the mark of the chosen object, and the paths of the inspected pixel.
function drawOverlays() {
  const mark = find('mark');
  const position = chosen && camera ? camera.project(chosen.position, screen.aspect) : null;
  mark.hidden = !position;
  if (position) Object.assign(mark.style, { left: `${100 * position[0]}%`, top: `${100 * position[1]}%` });
  inspector.draw(camera);
}

function showChosen() {
  if (!find('node')) return;
  setValue(find('node'), chosen ? chosen.index : '');
  find('placing').hidden = !chosen;
  find('move').setAttribute('aria-pressed', dragsChosen);
  if (chosen) ['x', 'y', 'z'].forEach((axis, i) => setValue(find(`node-${axis}`), Number(chosen.translation[i].toPrecision(6))));
  drawOverlays();
}

const sendChosen = oncePerFrame(() => {
  if (chosen) request(`position ${chosen.index}`, chosen.message);
});

function moveChosen() {
  showChosen();
  sendChosen();
}

function choose(index) {
  chosen = null;
  if (index === null) dragsChosen = false;
  else send({ do: 'node', node: index });
  showChosen();
}

// Purpose of the last pick: to choose an object, or to look at a position.
let pickPurpose = 'choose';

function pick([x, y], purpose) {
  pickPurpose = purpose;
  send({ do: 'pick', x, y });
}

steer(screen, {
  camera: () => (hasControl ? camera : null),
  moved: sendCamera,
  drags: (x, y, event) => {
    if (!dragsChosen || !chosen) return false;
    if (event.shiftKey) chosen.turn(x * TURN);
    else chosen.drag(camera, x, y);
    moveChosen();
    return true;
  },
  clicked: (position) => {
    if (find('inspect').getAttribute('aria-pressed') === 'true') send({ do: 'inspect', x: position[0], y: position[1] });
    else pick(position, 'choose');
  },
  focused: (position) => pick(position, 'focus'),
});

function showPicked(hit) {
  if (!hit) {
    notice('No surface at this pixel.');
    return;
  }
  const position = hit.position.map((value) => Number(value.toPrecision(5))).join(', ');
  if (find('node') && hit.node !== null && pickPurpose === 'choose') choose(hit.node);
  find('picked').textContent = `${hit.material} at (${position}) m, ${hit.distance.toPrecision(4)} m from the camera`;
  notice(find('picked').textContent);
  if (pickPurpose === 'focus' && camera) {
    camera.lookAt = hit.position;
    sendCamera();
  }
}

function showInspected(found) {
  notice('');
  find('picked').textContent = '';
  inspector.show(found, camera);
  rows(find('inspected'), inspector.lines());
  find('pixel').open = true;
  find('pixel').scrollIntoView({ block: 'nearest' });
}

// Keep overlays on the image when the window or the panel changes.
new ResizeObserver(drawOverlays).observe(find('stage'));
screen.resize(page.size);
