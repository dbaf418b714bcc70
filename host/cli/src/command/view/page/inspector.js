// Light transport of a pixel, drawn over the image: its camera path, the disc of its collection point, and light paths.
const CIRCLE = 48; // Number of corners of a disc.

class Inspector {
  constructor(canvas) {
    this.canvas = canvas;
    this.found = null;
  }

  show(found, camera) {
    this.found = found;
    this.draw(camera);
  }

  draw(camera) {
    const { canvas, found } = this;
    canvas.hidden = !found || !camera;
    if (canvas.hidden) return;
    const box = canvas.parentElement.getBoundingClientRect();
    [canvas.width, canvas.height] = [box.width * devicePixelRatio, box.height * devicePixelRatio];
    const context = canvas.getContext('2d');
    context.scale(devicePixelRatio, devicePixelRatio);
    const at = (position) => {
      const shares = camera.project(position, box.width / box.height);
      return shares && [shares[0] * box.width, shares[1] * box.height];
    };
    const line = (positions, color, width) => {
      context.beginPath();
      let isDown = false;
      for (const position of positions.map(at)) {
        if (position && isDown) context.lineTo(...position);
        else if (position) context.moveTo(...position);
        isDown = Boolean(position);
      }
      Object.assign(context, { strokeStyle: 'rgb(0 0 0 / 0.6)', lineWidth: width + 2 });
      context.stroke();
      Object.assign(context, { strokeStyle: color, lineWidth: width });
      context.stroke();
    };
    const dots = (vertices, color) => {
      for (const vertex of vertices) {
        const position = at(vertex.position);
        if (!position) continue;
        context.beginPath();
        context.arc(...position, 3.5, 0, 2 * Math.PI);
        Object.assign(context, { fillStyle: color, strokeStyle: '#000', lineWidth: 1 });
        context.fill();
        context.stroke();
      }
    };
    for (const path of found.light_paths) {
      line([path.start, ...path.vertices.map((vertex) => vertex.position)], '#ffd23f', 1.5);
      dots(path.vertices, '#ffd23f');
    }
    line(found.camera_path.vertices.map((vertex) => vertex.position), '#4ac8ff', 2);
    dots(found.camera_path.vertices, '#4ac8ff');
    if (found.point) line(Inspector.disc(found.point), '#7dff6a', 1.5);
  }

  // Positions on the circle of a collection point's disc.
  static disc({ position, normal, radius }) {
    const side = unit(cross(normal, Math.abs(normal[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0]));
    const other = cross(normal, side);
    return Array.from({ length: CIRCLE + 1 }, (_, i) => {
      const angle = (2 * Math.PI * i) / CIRCLE;
      return add(add(position, side, radius * Math.cos(angle)), other, radius * Math.sin(angle));
    });
  }

  // Description, as pairs of name and value.
  lines() {
    const { camera_path: path, point, photons } = this.found;
    const vertices = path.vertices.map((vertex, i) => [
      `${i + 1}. ${vertex.material || 'no material'}`,
      [vertex.event, ...vertex.lobes].join(', '),
    ]);
    const ofPoint = point ? [['radius of the collection point', `${number(point.radius)} m`]] : [['collection point', 'none']];
    const ofPhotons = photons
      ? [
          ['photons', photons.skipped ? `${photons.count}, ${photons.skipped} light paths not replayed` : String(photons.count)],
          ['radiance from photons', photons.radiance.map((value) => number(value)).join(' ')],
        ]
      : [];
    return [...vertices, ...ofPoint, ...ofPhotons];
  }
}
