// Images: two canvases; the upper one is clipped at the wipe.
class Screen {
  constructor(stage) {
    this.stage = stage;
    this.canvases = [...stage.querySelectorAll('canvas.image')];
    this.contexts = this.canvases.map((canvas) => canvas.getContext('2d', { alpha: false }));
    this.handle = stage.querySelector('.handle');
    this.wipeTo(0.5);
  }

  // Shows a packet of the server and returns its head.
  async show(packet) {
    const size = new DataView(packet).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(packet, 4, size)));
    const bytes = new Uint8Array(packet, 4 + size);
    const [canvas, context] = [this.canvases[head.side], this.contexts[head.side]];
    let image;
    if (head.format === 'jpeg') image = await createImageBitmap(new Blob([bytes], { type: 'image/jpeg' }));
    if (canvas.width !== head.width || canvas.height !== head.height) {
      [canvas.width, canvas.height] = [head.width, head.height];
    }
    if (image) {
      context.drawImage(image, 0, 0);
      image.close();
    } else {
      const data = context.createImageData(head.width, head.height);
      const words = new Uint32Array(data.data.buffer);
      for (let i = 0, j = 0; i < words.length; i += 1, j += 3) {
        words[i] = bytes[j] | (bytes[j + 1] << 8) | (bytes[j + 2] << 16) | 0xff000000;
      }
      context.putImageData(data, 0, 0);
    }
    canvas.hidden = false;
    this.stage.classList.toggle('split', !this.canvases[1].hidden);
    return head;
  }

  gone(side) {
    this.canvases[side].hidden = true;
    this.stage.classList.toggle('split', !this.canvases[1].hidden);
  }

  wipeTo(share) {
    this.at = Math.max(0, Math.min(1, share));
    this.stage.style.setProperty('--at', `${100 * this.at}%`);
    this.handle.setAttribute('aria-valuenow', Math.round(100 * this.at));
  }

  // Position of an event in the image, in shares of its width and height.
  position(event) {
    const box = this.stage.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  // Sets the aspect of the stage. Frames that move are a little off it, for their sizes are rounded.
  resize([width, height]) {
    document.documentElement.style.setProperty('--aspect', width / height);
  }

  get aspect() {
    const box = this.stage.getBoundingClientRect();
    return box.width / box.height;
  }
}
