// The connection, and what the panel says and does.
const page = JSON.parse(document.body.dataset.page);
const find = (id) => document.getElementById(id);
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const token = new URLSearchParams(location.search).get('token');
const MEMORY = `caustics-view ${page.scene}`;
const AGAIN = 1000; // Time until a lost connection is tried again (ms).

const screen = new Screen(find('stage'));
const inspector = new Inspector(find('overlay'));
let socket = null;
let status = null;
let camera = null;
let hasControl = false;
let isPending = false;
// What this page asked for, to be asked for again after the program was started anew.
let wanted = {};

function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

// Says something that the next run of the program is to know too.
function want(key, message) {
  wanted[key] = message;
  try {
    localStorage.setItem(MEMORY, JSON.stringify({ run: page.run, wanted }));
  } catch {
    // A browser that keeps nothing.
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

// At most one message of a camera a frame of the screen.
function moved() {
  if (isPending || !camera) return;
  isPending = true;
  requestAnimationFrame(() => {
    isPending = false;
    // As many digits as a single has, so that a command can be read.
    const round = (value) => Number(value.toPrecision(8));
    const [from, look_at] = [camera.from, camera.lookAt].map((position) => position.map(round));
    want('look', { do: 'look', from, look_at, fov: round(camera.fov), at: performance.now() });
    find('fov').value = camera.fov.toFixed(1);
    find('camera').value = '';
    mark();
    inspector.draw(camera);
  });
}

// The object that is chosen, and whether drags move it.
let thing = null;
let drags = false;
let isPlacing = false;

function mark() {
  const node = find('mark');
  const position = thing && camera ? camera.project(thing.position, screen.aspect) : null;
  node.hidden = !position;
  if (position) Object.assign(node.style, { left: `${100 * position[0]}%`, top: `${100 * position[1]}%` });
}

function showThing() {
  if (!find('node')) return;
  setValue(find('node'), thing ? thing.index : '');
  find('placing').hidden = !thing;
  find('move').setAttribute('aria-pressed', drags);
  if (thing) ['x', 'y', 'z'].forEach((axis, i) => setValue(find(`node-${axis}`), Number(thing.translation[i].toPrecision(6))));
  mark();
}

// At most one message of an object a frame of the screen.
function placed() {
  showThing();
  if (isPlacing) return;
  isPlacing = true;
  requestAnimationFrame(() => {
    isPlacing = false;
    if (thing) want(`position ${thing.index}`, thing.message);
  });
}

function choose(index) {
  thing = null;
  if (index === null) drags = false;
  else send({ do: 'node', node: index });
  showThing();
}

steer(screen, {
  camera: () => (hasControl ? camera : null),
  moved,
  drags: (x, y, event) => {
    if (!drags || !thing) return false;
    if (event.shiftKey) thing.turn(x * TURN);
    else thing.drag(camera, x, y);
    placed();
    return true;
  },
  clicked: ([x, y]) => {
    if (find('inspect').getAttribute('aria-pressed') === 'true') {
      send({ do: 'inspect', x, y });
      return;
    }
    pickFor = 'choose';
    send({ do: 'pick', x, y });
  },
  focused: ([x, y]) => {
    pickFor = 'focus';
    send({ do: 'pick', x, y });
  },
});
let pickFor = 'choose';

function picked(what) {
  if (!what) {
    notice('nothing is there');
    return;
  }
  const position = what.position.map((value) => Number(value.toPrecision(5))).join(', ');
  if (find('node') && what.node !== null && pickFor === 'choose') choose(what.node);
  find('picked').textContent = `${what.material} at ${position}, ${what.distance.toPrecision(4)} m away`;
  if (pickFor === 'focus' && camera) {
    camera.lookAt = what.position;
    moved();
  }
}

// The table of axes, times, counters.
function setValue(node, value) {
  if (node && document.activeElement !== node && node.value !== String(value)) node.value = value;
}

const number = (value, digits = 3) =>
  value === null || value === undefined ? '–' : Number(value) >= 1e5 ? Number(value).toExponential(2) : String(Number(Number(value).toPrecision(digits)));

function rows(node, pairs) {
  node.replaceChildren(
    ...pairs.map(([name, value]) => {
      const row = document.createElement('tr');
      const [head, cell] = [document.createElement('th'), document.createElement('td')];
      head.scope = 'row';
      head.textContent = name;
      cell.textContent = value;
      row.append(head, cell);
      return row;
    }),
  );
}

function showStatus(now) {
  if (now.records && now.is_full && !(status && status.is_full)) notice('the recording is full: save it as Animation, and record anew', 0);
  status = now;
  if (now.camera && (!camera || !isPending)) {
    const distance = camera ? camera.distance : page.distance;
    const isOther = !camera || length(add(camera.from, now.camera.from, -1)) > 1e-4 * distance || Math.abs(camera.fov - now.camera.fov) > 0.01;
    // The page with the control token knows best where it is, but for cameras of the file.
    if (!camera || !hasControl || (now.camera.name && isOther)) camera = Camera.from(now.camera, distance);
    setValue(find('camera'), now.camera.name || '');
    setValue(find('fov'), camera.fov.toFixed(1));
  }
  now.axes.forEach((axes, side) => {
    for (const [key, { value, not_applicable }] of Object.entries(axes)) {
      const node = find(`axis-${side}-${key}`);
      if (!node) continue;
      setValue(node, value);
      node.disabled = !hasControl || Boolean(not_applicable);
      node.title = not_applicable ? `this method ${not_applicable}` : '';
    }
  });
  setValue(find('against'), now.against);
  setValue(find('layer'), now.layer);
  setValue(find('width'), now.size[0]);
  setValue(find('height'), now.size[1]);
  setValue(find('rate'), now.target_fps);
  find('other').hidden = now.against !== 'other';
  document.body.classList.toggle('two', now.against === 'other');
  find('pause').setAttribute('aria-pressed', now.paused);
  if (find('time')) {
    if (document.activeElement !== find('time')) find('time').value = now.time;
    find('seconds').textContent = `${now.time.toFixed(2)} of ${now.duration.toFixed(2)} s`;
    find('play').setAttribute('aria-pressed', now.playing);
  }
  const { image, other } = now;
  if (image) {
    const fps = image.frame_ms ? 1000 / image.frame_ms : 0;
    find('device').textContent = `${image.device} (${image.why})`;
    const about = (of) => [
      ['size', `${of.size[0]} x ${of.size[1]} px`],
      ['frame', `${number(of.frame_ms)} ms`],
      ['samples', number(of.samples, 6)],
      ['estimated relMSE', number(of.error)],
      ['light paths', number(of.light_paths, 6)],
      ...Object.entries(of.rates).map(([name, value]) => [name.replace('_per_s', '').replaceAll('_', ' '), `${number(value / 1e6)} M a second`]),
    ];
    rows(find('numbers'), about(image));
    rows(find('passes'), Object.entries(image.pass_ms).map(([name, ms]) => [name, `${number(ms)} ms`]));
    find('state').textContent = now.paused
      ? 'paused'
      : now.moves
        ? `moving, ${number(fps)} frames/s at ${image.size[0]} x ${image.size[1]}, answered in ${number(document.body.dataset.latency)} ms`
        : `${image.samples} samples, ${number(image.seconds, 3)} s, error ${number(image.error)}`;
    find('numbers-other').hidden = !other;
    if (other) rows(find('numbers-other').lastElementChild, about(other));
    const warnings = [...now.warnings, ...image.warnings];
    find('warnings').replaceChildren(...warnings.map((text) => Object.assign(document.createElement('li'), { textContent: text })));
    find('warned').hidden = !warnings.length;
  }
  if (now.distance) rows(find('distance'), Object.entries(now.distance).map(([name, value]) => [name, number(value)]));
  find('distance').hidden = !now.distance;
  find('save-edits').hidden = !now.edited.length;
  find('save-recording').hidden = now.recorded < 2;
  find('record').setAttribute('aria-pressed', now.records);
  if (now.command !== undefined) find('command').textContent = now.command || '';
  find('command').classList.toggle('dim', !now.command);
  find('copy').disabled = !now.command;
  find('failure').textContent = now.failure || '';
  find('failure').hidden = !now.failure;
}

function showControl(now) {
  hasControl = now.has_control;
  document.body.classList.toggle('onlooker', !hasControl);
  all('[data-control]').forEach((node) => { node.disabled = !hasControl; });
  find('take').hidden = hasControl;
  find('pages').textContent = now.pages > 1 ? `${now.pages} pages look on` : '';
}

const heads = {
  status: showStatus,
  control: showControl,
  picked: (now) => picked(now.what),
  node: (now) => {
    thing = now.what ? new Thing(now.what) : null;
    showThing();
  },
  inspected: (now) => {
    inspector.show(now.what, camera);
    rows(find('inspected'), inspector.lines());
  },
  error: (now) => notice(now.what),
  gone: (now) => screen.gone(now.side),
  hello: (now) => {
    // Another run of the program: send it what this page set in the one before.
    if (page.run !== now.run) {
      page.run = now.run;
      Object.values(wanted).forEach(send);
    }
  },
};

function connect() {
  const address = new URL('connection', location.href);
  address.protocol = 'ws:';
  address.search = `?token=${token}`;
  socket = new WebSocket(address);
  socket.binaryType = 'arraybuffer';
  socket.addEventListener('open', () => {
    document.body.classList.remove('lost');
    notice('');
  });
  socket.addEventListener('message', async ({ data }) => {
    if (typeof data === 'string') {
      const now = JSON.parse(data);
      if (heads[now.is]) heads[now.is](now);
      return;
    }
    const head = await screen.show(data);
    if (head.moves && hasControl && head.at > 0) {
      const took = performance.now() - head.at;
      if (took < 60000) document.body.dataset.latency = took;
    }
    document.body.dataset.encode = head.encode_ms;
    document.body.dataset.serial = head.serial;
    document.body.dataset.samples = head.samples;
    document.body.dataset.format = head.format;
    find('scale').textContent = head.brightest === null ? `${head.stops.toFixed(1)} stops` : `0 to ${number(head.brightest)}`;
    send({ do: 'shown', serial: head.serial });
  });
  socket.addEventListener('close', () => {
    document.body.classList.add('lost');
    notice('the connection is lost; trying again', 0);
    setTimeout(connect, AGAIN);
  });
}

// The panel.
all('[data-axis]').forEach((node) => {
  node.addEventListener('change', () => {
    const { side, axis } = node.dataset;
    want(`axis ${side} ${axis}`, { do: 'axis', side: Number(side), key: axis, value: node.value.trim() });
  });
});
const onChange = (id, message) => {
  const node = find(id);
  if (node) node.addEventListener('change', () => { const what = message(node); if (what) want(id, what); });
};
onChange('camera', ({ value }) => {
  delete wanted.look;
  camera = null;
  return value ? { do: 'camera', name: value } : null;
});
find('fov').addEventListener('change', ({ target }) => {
  if (!camera || !(target.value > 0)) return;
  camera.fov = Number(target.value);
  moved();
});
onChange('against', ({ value }) => ({ do: 'against', what: value }));
onChange('layer', ({ value }) => ({ do: 'layer', name: value }));
onChange('rate', ({ value }) => ({ do: 'rate', fps: Number(value) }));
const size = () => ({ do: 'size', width: Number(find('width').value), height: Number(find('height').value) });
['width', 'height'].forEach((id) => find(id).addEventListener('change', () => want('size', size())));
const exposure = () => ({ do: 'exposure', stops: find('auto').checked ? 'auto' : find('stops').value });
['auto', 'stops'].forEach((id) => find(id).addEventListener('input', () => {
  if (id === 'stops') find('auto').checked = false;
  want('exposure', exposure());
}));
const clock = (isPlaying) => ({ do: 'time', seconds: Number(find('time').value), playing: isPlaying });
if (find('time')) {
  find('time').addEventListener('input', () => want('time', clock(false)));
  find('play').addEventListener('click', () => want('time', clock(!status.playing)));
}
find('pause').addEventListener('click', () => send({ do: 'pause', paused: !status.paused }));
find('inspect').addEventListener('click', ({ currentTarget }) => {
  const isOn = currentTarget.getAttribute('aria-pressed') !== 'true';
  currentTarget.setAttribute('aria-pressed', isOn);
  if (isOn) notice('click a pixel');
  else {
    inspector.show(null, camera);
    find('inspected').replaceChildren();
  }
});
addEventListener('resize', () => {
  inspector.draw(camera);
  mark();
});
find('record').addEventListener('click', () => send({ do: 'record', on: !status.records }));
if (find('node')) {
  find('node').addEventListener('change', ({ target }) => choose(target.value === '' ? null : Number(target.value)));
  find('move').addEventListener('click', () => {
    drags = !drags;
    showThing();
  });
  find('put-back').addEventListener('click', () => {
    if (!thing) return;
    delete wanted[`position ${thing.index}`];
    send({ do: 'put_back', node: thing.index });
    choose(thing.index);
  });
  ['x', 'y', 'z'].forEach((axis, i) => find(`node-${axis}`).addEventListener('change', ({ target }) => {
    if (!thing || target.value === '') return;
    thing.translation[i] = Number(target.value);
    placed();
    choose(thing.index);
  }));
}
find('take').addEventListener('click', () => send({ do: 'take_control' }));
find('copy').addEventListener('click', async () => {
  try {
    await navigator.clipboard.writeText(find('command').textContent);
    notice('copied');
  } catch {
    getSelection().selectAllChildren(find('command'));
    notice('select and copy the command below');
  }
});
all('[data-save]').forEach((node) => {
  node.addEventListener('click', async () => {
    const name = node.dataset.save;
    const response = await fetch(`${name}?token=${token}`);
    if (!response.ok) {
      notice(await response.text());
      return;
    }
    const link = document.createElement('a');
    link.href = URL.createObjectURL(await response.blob());
    link.download = `${page.scene}-${name}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  });
});
// What a page of an earlier run wanted can be had again.
try {
  const kept = JSON.parse(localStorage.getItem(MEMORY) || 'null');
  if (kept && kept.run !== page.run && Object.keys(kept.wanted).length) {
    find('restore').hidden = false;
    find('restore').addEventListener('click', () => {
      wanted = kept.wanted;
      Object.entries(wanted).forEach(([key, message]) => want(key, message));
      camera = null;
      find('restore').hidden = true;
    });
  }
} catch {
  // A browser that keeps nothing.
}
connect();
