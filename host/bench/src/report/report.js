'use strict';
(() => {
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const tip = document.getElementById('tip');
  const REACH = 26; // How far a pointer may be from a mark that it means [px].

  // Titles are for readers without this script; two hints at once are one too many.
  all('.chart title').forEach((title) => {
    title.parentNode.setAttribute('aria-label', title.textContent);
    title.remove();
  });

  // Shows what is known of a mark, beside it and inside of the window.
  let marked = null;
  function show(mark, x, y) {
    if (marked !== mark) {
      if (marked) marked.classList.remove('near');
      marked = mark;
      mark.classList.add('near');
      const [head, ...lines] = mark.dataset.tip.split('\n');
      const bold = document.createElement('b');
      bold.textContent = head;
      tip.replaceChildren(bold, lines.join('\n'));
    }
    tip.hidden = false;
    const { width, height } = tip.getBoundingClientRect();
    const page = document.documentElement.clientWidth;
    const left = x + 18 + width < page ? x + 18 : x - 18 - width;
    const top = y + 18 + height < innerHeight ? y + 18 : y - 18 - height;
    tip.style.left = `${Math.max(8, Math.min(left, page - width - 8))}px`;
    tip.style.top = `${Math.max(8, top)}px`;
  }
  function hide() {
    if (marked) marked.classList.remove('near');
    marked = null;
    tip.hidden = true;
  }

  // The mark nearest to a position of the window, if it is near enough.
  function nearest(chart, x, y) {
    const from = chart.getScreenCTM();
    let best = null;
    let least = REACH * REACH;
    for (const mark of chart.marks) {
      if (mark.classList.contains('off')) continue;
      const dx = from.a * mark.dataset.x + from.e - x;
      const dy = from.d * mark.dataset.y + from.f - y;
      if (dx * dx + dy * dy < least) {
        least = dx * dx + dy * dy;
        best = mark;
      }
    }
    return best;
  }
  all('.chart').forEach((chart) => {
    chart.marks = all('[data-x]', chart);
    const point = (event) => {
      const mark = chart.marks.length
        ? nearest(chart, event.clientX, event.clientY)
        : event.target.closest('[data-tip]');
      if (mark) show(mark, event.clientX, event.clientY);
      else hide();
    };
    chart.addEventListener('pointermove', point);
    chart.addEventListener('pointerdown', point);
    chart.addEventListener('pointerleave', (event) => {
      if (event.pointerType === 'mouse') hide();
    });
    const beside = (mark) => {
      const box = mark.getBoundingClientRect();
      show(mark, Math.min(box.right, innerWidth) - 6, box.top + Math.min(box.height, 40) / 2);
    };
    chart.addEventListener('focusin', (event) => {
      const mark = event.target.closest('[data-tip]');
      if (mark && mark.matches(':focus-visible')) beside(mark);
    });
    // A tap moves the focus after it has shown another mark: that one stays.
    chart.addEventListener('focusout', (event) => {
      if (event.target.closest('[data-tip]') === marked) hide();
    });

    // One stop of the tab key a chart; arrows go on to its neighbours, from the left to the right.
    const points = all('.point', chart).sort((a, b) => a.dataset.x - b.dataset.x);
    points.forEach((mark, index) => {
      mark.tabIndex = index ? -1 : 0;
    });
    chart.addEventListener('keydown', (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      const seen = points.filter((mark) => !mark.classList.contains('off'));
      const index = seen.indexOf(event.target);
      if (!step || index < 0) return;
      event.preventDefault();
      const next = seen[(index + step + seen.length) % seen.length];
      points.forEach((mark) => {
        mark.tabIndex = mark === next ? 0 : -1;
      });
      next.focus({ focusVisible: true });
    });
  });
  document.addEventListener('pointerdown', (event) => {
    if (!event.target.closest('.chart')) hide();
  });
  document.addEventListener('scroll', hide, { passive: true, capture: true });
  document.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') hide();
  });

  // One chart of a scene at a time, and series that can be put out of the way in all of them.
  all('[data-charts]').forEach((panel) => {
    const charts = all('[data-chart]', panel);
    const buttons = all('[data-show]', panel);
    const choose = (name) => {
      hide();
      charts.forEach((chart) => {
        chart.hidden = chart.dataset.chart !== name;
      });
      buttons.forEach((button) => button.setAttribute('aria-pressed', button.dataset.show === name));
    };
    if (charts.length > 1) choose(charts[0].dataset.chart);
    buttons.forEach((button) => button.addEventListener('click', () => choose(button.dataset.show)));
    all('[data-toggle]', panel).forEach((button) => {
      button.addEventListener('click', () => {
        const on = button.getAttribute('aria-pressed') !== 'true';
        button.setAttribute('aria-pressed', on);
        all(`[data-series="${button.dataset.toggle}"]`, panel).forEach((mark) => mark.classList.toggle('off', !on));
        all('.chart', panel).forEach((chart) => {
          const seen = all('.point:not(.off)', chart);
          if (seen.length && !seen.some((mark) => mark.tabIndex === 0)) seen[0].tabIndex = 0;
        });
      });
    });
  });

  // The wipe follows pointer and keys.
  all('.wipe-box').forEach((box) => {
    const wipe = box.querySelector('[data-wipe]');
    const handle = box.querySelector('.handle');
    const choice = box.querySelector('[data-wipe-choice]');
    let at = 50;
    const set = (value) => {
      at = Math.max(0, Math.min(100, value));
      wipe.style.setProperty('--at', `${at}%`);
      handle.setAttribute('aria-valuenow', Math.round(at));
      handle.setAttribute('aria-valuetext', `${Math.round(at)} %`);
    };
    const follow = (event) => {
      const frame = wipe.getBoundingClientRect();
      set((100 * (event.clientX - frame.left)) / frame.width);
    };
    wipe.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      wipe.setPointerCapture(event.pointerId);
      handle.focus({ preventScroll: true });
      follow(event);
      event.preventDefault();
    });
    wipe.addEventListener('pointermove', (event) => {
      if (wipe.hasPointerCapture(event.pointerId)) follow(event);
    });
    handle.addEventListener('keydown', (event) => {
      const step = event.shiftKey ? 10 : 2;
      const to = { ArrowLeft: at - step, ArrowDown: at - step, ArrowRight: at + step, ArrowUp: at + step, Home: 0, End: 100 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      set(to);
    });
    choice.addEventListener('change', () => {
      const option = choice.selectedOptions[0];
      box.querySelector('[data-part="cell"]').setAttribute('href', option.value);
      box.querySelector('[data-part="reference"]').setAttribute('href', option.dataset.reference);
      all('.image', wipe).forEach((image) => image.setAttribute('viewBox', option.dataset.view));
      wipe.querySelector('.tag.left').textContent = option.textContent;
    });
  });

  // A click on a head sorts by its column, another one the other way round; rows without a value come last.
  all('table[data-sortable]').forEach((table) => {
    const heads = all('th', table);
    heads.forEach((head, column) => {
      head.querySelector('button').addEventListener('click', () => {
        const up = head.getAttribute('aria-sort') !== 'ascending';
        heads.forEach((other) => other.removeAttribute('aria-sort'));
        head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
        const body = table.tBodies[0];
        const value = (row) => {
          const cell = row.cells[column];
          if (cell.dataset.value !== undefined) return Number(cell.dataset.value);
          return cell.classList.contains('none') ? null : cell.textContent;
        };
        const order = (a, b) => {
          const [x, y] = [value(a), value(b)];
          if (x === null || y === null) return (x === null) - (y === null);
          const sign = typeof x === 'number' && typeof y === 'number' ? x - y : String(x).localeCompare(String(y));
          return up ? sign : -sign;
        };
        body.append(...[...body.rows].sort(order));
      });
    });
  });
})();
