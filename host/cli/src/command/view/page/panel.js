// Controls of the bar and the panel.
const onChange = (id, message) => {
  const node = find(id);
  if (!node) return;
  node.addEventListener('change', () => {
    const change = message(node);
    if (change) request(id, change);
  });
};
const onClick = (id, action) => {
  if (find(id)) find(id).addEventListener('click', action);
};

// Hide and show the panel.
function togglePanel() {
  const [panel, toggle] = [find('panel'), find('toggle')];
  if (panel.contains(document.activeElement)) toggle.focus();
  panel.hidden = !panel.hidden;
  document.body.classList.toggle('bare', panel.hidden);
  toggle.setAttribute('aria-expanded', !panel.hidden);
  toggle.textContent = panel.hidden ? 'Show panel' : 'Hide panel';
}
onClick('toggle', togglePanel);
addEventListener('keydown', (event) => {
  const isTyping = event.target.matches('input:not([type="checkbox"], [type="range"]), select');
  if (event.key.toLowerCase() !== 'h' || isTyping || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  togglePanel();
});

// Set parameters.
all('[data-parameter]').forEach((node) => {
  node.addEventListener('change', () => {
    const { side, parameter } = node.dataset;
    request(`parameter ${side} ${parameter}`, { do: 'axis', side: Number(side), key: parameter, value: node.value.trim() });
  });
});

// Set camera, time and display.
onChange('camera', ({ value }) => {
  delete requests.look;
  camera = null;
  return value ? { do: 'camera', name: value } : null;
});
find('fov').addEventListener('change', ({ target }) => {
  if (!camera || !(target.value > 0)) return;
  camera.fov = Number(target.value);
  sendCamera();
});
onChange('against', ({ value }) => ({ do: 'against', what: value }));
onChange('layer', ({ value }) => ({ do: 'layer', name: value }));
['auto', 'stops'].forEach((id) => find(id).addEventListener('input', () => {
  if (id === 'stops') find('auto').checked = false;
  request('exposure', { do: 'exposure', stops: find('auto').checked ? 'auto' : find('stops').value });
}));
const setTime = (isPlaying) => request('time', { do: 'time', seconds: Number(find('time').value), playing: isPlaying });
if (find('time')) find('time').addEventListener('input', () => setTime(false));
onClick('play', () => setTime(!status.playing));

// Set size and rate.
onChange('rate', ({ value }) => ({ do: 'rate', fps: Number(value) }));
['width', 'height'].forEach((id) => find(id).addEventListener('change', () => {
  request('size', { do: 'size', width: Number(find('width').value), height: Number(find('height').value) });
}));
onClick('pause', () => send({ do: 'pause', paused: !status.paused }));

onClick('inspect', ({ currentTarget }) => {
  const isOn = currentTarget.getAttribute('aria-pressed') !== 'true';
  currentTarget.setAttribute('aria-pressed', isOn);
  if (isOn) notice('Click a pixel of the image.');
  else {
    inspector.show(null, camera);
    find('inspected').replaceChildren();
  }
});

// Move objects.
if (find('node')) find('node').addEventListener('change', ({ target }) => choose(target.value === '' ? null : Number(target.value)));
onClick('move', () => {
  dragsChosen = !dragsChosen;
  showChosen();
});
onClick('put-back', () => {
  if (!chosen) return;
  delete requests[`position ${chosen.index}`];
  send({ do: 'put_back', node: chosen.index });
  choose(chosen.index);
});
['x', 'y', 'z'].forEach((axis, i) => {
  const node = find(`node-${axis}`);
  if (!node) return;
  node.addEventListener('change', () => {
    if (!chosen || node.value === '') return;
    chosen.translation[i] = Number(node.value);
    moveChosen();
    choose(chosen.index);
  });
});

// Record, copy and save.
onClick('record', () => send({ do: 'record', on: !status.records }));
onClick('copy', async () => {
  try {
    await navigator.clipboard.writeText(find('command').textContent);
    notice('The command is copied.');
  } catch {
    getSelection().selectAllChildren(find('command'));
    notice('The browser denies access to the clipboard. The command is selected: copy it.');
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

// Offer the requests of a page of an earlier run.
onClick('take', () => send({ do: 'take_control' }));
try {
  const kept = JSON.parse(localStorage.getItem(MEMORY) || 'null');
  if (kept && kept.run !== page.run && Object.keys(kept.requests).length) {
    find('restore').hidden = false;
    onClick('restore', () => {
      requests = kept.requests;
      Object.entries(requests).forEach(([key, message]) => request(key, message));
      camera = null;
      find('restore').hidden = true;
    });
  }
} catch {
  // The browser stores nothing.
}
