// Connection to the program: messages and images.
const RETRY_MS = 1000; // Time until a lost connection is tried again.

const handlers = {
  status: showStatus,
  control: showControl,
  picked: (message) => showPicked(message.what),
  node: (message) => {
    chosen = message.what ? new EditedNode(message.what) : null;
    showChosen();
  },
  inspected: (message) => showInspected(message.what),
  error: (message) => notice(message.what),
  gone: (message) => screen.gone(message.side),
  hello: (message) => {
    // Repeat the requests of this page to another run of the program.
    if (page.run !== message.run) {
      page.run = message.run;
      Object.values(requests).forEach(send);
    }
  },
};

async function showImage(packet) {
  const head = await screen.show(packet);
  if (head.moves && hasControl && head.at > 0) {
    const took = performance.now() - head.at;
    if (took < 60000) document.body.dataset.latency = took;
  }
  document.body.dataset.encode = head.encode_ms;
  document.body.dataset.serial = head.serial;
  document.body.dataset.samples = head.samples;
  document.body.dataset.format = head.format;
  const isLight = head.brightest === null;
  find('scale').textContent = isLight ? `exposure ${head.stops.toFixed(1)} stops` : `colours from 0 to ${number(head.brightest)}`;
  send({ do: 'shown', serial: head.serial });
}

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
      const message = JSON.parse(data);
      if (handlers[message.is]) handlers[message.is](message);
    } else {
      await showImage(data);
    }
  });
  socket.addEventListener('close', () => {
    document.body.classList.add('lost');
    notice('The connection to the program is lost. Trying again.', 0);
    setTimeout(connect, RETRY_MS);
  });
}
connect();
