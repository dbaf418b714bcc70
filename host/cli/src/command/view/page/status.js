// Status of the renderer, shown in the bar and the panel.
function setValue(node, value) {
  if (node && document.activeElement !== node && node.value !== String(value)) node.value = value;
}

function number(value, digits = 3) {
  if (value === null || value === undefined) return '–';
  return Number(value) >= 1e5 ? Number(value).toExponential(2) : String(Number(Number(value).toPrecision(digits)));
}

function rows(table, pairs) {
  table.replaceChildren(
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

function showCamera(shown) {
  const distance = camera ? camera.distance : page.distance;
  const isOther = !camera || length(add(camera.from, shown.from, -1)) > 1e-4 * distance || Math.abs(camera.fov - shown.fov) > 0.01;
  // A page with control moves the camera itself, and takes over cameras of the file alone.
  if (!camera || !hasControl || (shown.name && isOther)) camera = Camera.from(shown, distance);
  setValue(find('camera'), shown.name || '');
  setValue(find('fov'), camera.fov.toFixed(1));
}

// Shows the parameters of a side. Those that do not apply to its method are hidden, and listed with the reason.
function showParameters(parameters, side) {
  const reasons = new Map();
  for (const [key, { value, not_applicable }] of Object.entries(parameters)) {
    const node = find(`parameter-${side}-${key}`);
    if (!node) continue;
    const field = node.closest('.field');
    setValue(node, value);
    field.hidden = Boolean(not_applicable);
    node.disabled = !hasControl || field.hidden;
    if (!field.hidden) continue;
    const names = reasons.get(not_applicable) || [];
    reasons.set(not_applicable, [...names, field.querySelector('label').textContent]);
  }
  const note = find(`not-applicable-${side}`);
  const lines = [...reasons].map(([reason, names]) => `${names.join(', ')} (${reason})`);
  note.textContent = `Not applicable: ${lines.join('; ')}.`;
  note.hidden = !lines.length;
}

function statistics(job) {
  const nameOf = (rate) => rate.replace('_per_s', '').replaceAll('_', ' ');
  const rates = Object.entries(job.rates).map(([rate, value]) => [nameOf(rate), `${number(value / 1e6)} M/s`]);
  return [
    ['image size', `${job.size[0]} x ${job.size[1]} px`],
    ['frame time', `${number(job.frame_ms)} ms`],
    ['samples', number(job.samples, 6)],
    ['estimated relMSE', number(job.error)],
    ['light paths per frame', number(job.light_paths, 6)],
    ...rates,
  ];
}

// Progress in one line.
function progress(now, job) {
  if (now.paused) return 'paused';
  if (!now.moves) return `${job.samples} samples, ${number(job.seconds)} s, relMSE ${number(job.error, 2)}`;
  const rate = number(job.frame_ms ? 1000 / job.frame_ms : 0);
  return `moving, ${rate} frames/s, latency ${number(document.body.dataset.latency)} ms`;
}

function showImages(now) {
  const { image, other } = now;
  find('state').textContent = progress(now, image);
  find('size').textContent = `${image.size[0]} x ${image.size[1]} px`;
  find('device').textContent = `${image.device} (${image.why})`;
  rows(find('numbers'), statistics(image));
  rows(find('passes'), Object.entries(image.pass_ms).map(([name, ms]) => [name, `${number(ms)} ms`]));
  find('numbers-other').hidden = !other;
  if (other) rows(find('numbers-other').lastElementChild, statistics(other));
  const warnings = [...now.warnings, ...image.warnings];
  find('warnings').replaceChildren(...warnings.map((text) => Object.assign(document.createElement('li'), { textContent: text })));
  find('warning-count').textContent = `Warnings (${warnings.length})`;
  find('warned').hidden = !warnings.length;
}

function showTime(now) {
  if (!find('time')) return;
  if (document.activeElement !== find('time')) find('time').value = now.time;
  find('seconds').textContent = `${now.time.toFixed(2)} of ${now.duration.toFixed(2)} s`;
  find('play').setAttribute('aria-pressed', now.playing);
}

function showStatus(now) {
  if (now.records && now.is_full && !(status && status.is_full)) {
    notice('The recording is full. Save the animation, then start a new recording.', 0);
  }
  status = now;
  screen.resize(now.size);
  if (now.camera && (!camera || !sendCamera.isPending)) showCamera(now.camera);
  now.axes.forEach(showParameters);
  setValue(find('against'), now.against);
  setValue(find('layer'), now.layer);
  setValue(find('width'), now.size[0]);
  setValue(find('height'), now.size[1]);
  setValue(find('rate'), now.target_fps);
  find('other').hidden = now.against !== 'other';
  document.body.classList.toggle('compared', now.against !== 'nothing');
  find('pause').setAttribute('aria-pressed', now.paused);
  showTime(now);
  if (now.image) showImages(now);
  // The last comparison outlives its end.
  const measures = now.against === 'nothing' ? [] : Object.entries(now.distance || {});
  rows(find('distance'), measures.map(([name, value]) => [name === 'energy' ? 'ratio of energies' : name, number(value)]));
  find('distance').hidden = !measures.length;
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
  find('pages').textContent = now.pages > 1 ? `${now.pages} pages are open` : '';
}
