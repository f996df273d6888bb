#pragma once
// SPDX-License-Identifier: MIT
//
// The script and the style of the page, as text that goes into it unchanged.
//
// The player draws on a canvas. It scales the model's plane to fit with equal units on both axes, interpolates between frames, and moves
// a cursor along every plot whose x axis is time. Space plays and pauses, the arrow keys step. It starts by itself unless the reader
// asked the system for less motion. A picture in space is turned by dragging it, or by shift and the arrow keys.

namespace qdot::report::detail {

inline constexpr const char* page_css = R"css(
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.55 system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}
main{max-width:1180px;margin:0 auto;padding:32px 20px 40px}
h1{font-size:26px;line-height:1.2;margin:0 0 4px;letter-spacing:-.01em;font-weight:650}
h2{font-size:12.5px;font-weight:600;color:var(--muted);margin:0 0 8px}
.lead{color:var(--muted);margin:0 0 24px;max-width:70ch}
.grid{display:grid;gap:16px;grid-template-columns:repeat(12,minmax(0,1fr))}
.card{background:var(--card);border:1px solid var(--rule);border-radius:8px;padding:16px}
.stage{grid-column:span 7;display:flex;flex-direction:column}.facts{grid-column:span 5;display:grid;gap:16px;align-content:start}.wide{grid-column:span 12}.half{grid-column:span 6}
@media(max-width:860px){.stage,.facts,.half{grid-column:span 12}.screen{min-height:0;aspect-ratio:4/3}}
.screen{position:relative;flex:1;min-height:440px}
canvas{position:absolute;inset:0;width:100%;height:100%;touch-action:pan-y}
.bar{display:flex;align-items:center;gap:12px;margin-top:12px}
.bar input{flex:1;min-width:60px;accent-color:var(--s0);margin:0}
.bar button,.bar select{font:inherit;font-size:13px;color:var(--ink);background:var(--paper);border:1px solid var(--rule);border-radius:6px;height:32px;padding:0 8px}
.bar button{width:36px;padding:0;display:grid;place-items:center;cursor:pointer}
.bar button:hover,.bar select:hover{border-color:var(--muted)}
.bar svg{width:14px;height:14px;fill:currentColor}
.bar output{font-size:13px;color:var(--muted);font-variant-numeric:tabular-nums;min-width:10ch;text-align:right}
table{border-collapse:collapse;width:100%;font-size:14px}
td{padding:4px 0;border-top:1px solid var(--rule);vertical-align:baseline}
tr:first-child td{border-top:0}
td:first-child{color:var(--muted);padding-right:16px}
td.value{text-align:right;font-variant-numeric:tabular-nums;overflow-wrap:anywhere}
td small{color:var(--muted);font-size:12.5px}
.formulas{overflow-x:auto;display:grid;grid-template-columns:max-content 1fr;column-gap:24px;align-items:baseline}
.formulas h2{grid-column:span 2}
.formulas h3{grid-column:1;font-size:13px;font-weight:400;color:var(--muted);margin:4px 0}
.formulas div{grid-column:2}
.formulas p{margin:6px 0}.formulas math{font-size:17px;font-family:'STIX Two Math','STIX Math','Latin Modern Math','Cambria Math','Libertinus Math','DejaVu Math TeX Gyre',math}
svg.plot{display:block;width:100%;height:auto}
svg[data-time]{cursor:crosshair}
footer{color:var(--muted);font-size:13px;margin-top:20px}
)css";

inline constexpr const char* player_script = R"js(
(function () {
  const data = JSON.parse(document.getElementById('animation').textContent);
  const canvas = document.getElementById('stage'), pen = canvas.getContext('2d');
  const play = document.getElementById('play'), scrub = document.getElementById('scrub');
  const speed = document.getElementById('speed'), clock = document.getElementById('clock');
  const times = data.times, last = times.length - 1;
  let frames = data.frames, backdrop = data.backdrop, box = [Infinity, Infinity, -Infinity, -Infinity];
  const start = times[0], end = times[last], decimals = Math.max(0, 2 - Math.floor(Math.log10((end - start) / 10)));
  let now = start, playing = false, before = 0, width = 0, height = 0, zoom = 1, shiftX = 0, shiftY = 0;

  // What must be visible: every point of every frame, the boxes around points, the backdrop.
  const see = (x, y) => { box = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)]; };
  const hidden = new Set(data.shapes.filter(s => s.kind === 'ellipse').flatMap(s => s.points));
  data.shapes.filter(s => s.kind !== 'ellipse').forEach(s => s.points.forEach(p => hidden.delete(p)));
  const findBox = () => { for (const f of frames) {
    for (let i = 0; i < f.length; i += 2) if (!hidden.has(i / 2)) see(f[i], f[i + 1]);
    for (const s of data.shapes) {
      if (s.kind === 'box') {
        const x = f[2 * s.points[0]], y = f[2 * s.points[0] + 1];
        see(x - s.size / 2, y - s.size2 / 2); see(x + s.size / 2, y + s.size2 / 2);
      } else if (s.kind === 'ellipse') {
        const [c, a, b] = s.points.map(p => [f[2 * p], f[2 * p + 1]]);
        const rx = Math.hypot(a[0] - c[0], b[0] - c[0]), ry = Math.hypot(a[1] - c[1], b[1] - c[1]);
        see(c[0] - rx, c[1] - ry); see(c[0] + rx, c[1] + ry);
      }
    }
  }
  backdrop.forEach(l => l.forEach(p => see(p[0], p[1]))); };

  // Of a picture in space, what a camera sees from angles in degrees. Whatever these are, the ball around all that it can see has its place.
  let side = 0, above = 0, ball = 0;
  function look() {
    const ca = Math.cos(side * Math.PI / 180), sa = Math.sin(side * Math.PI / 180), ce = Math.cos(above * Math.PI / 180), se = Math.sin(above * Math.PI / 180);
    const eye = (x, y, z) => [ca * x + sa * y, ce * z + se * (ca * y - sa * x)];
    frames = data.frames.map(f => { const g = []; for (let i = 0; i < f.length; i += 3) g.push(...eye(f[i], f[i + 1], f[i + 2])); return g; });
    backdrop = data.backdrop.map(l => l.map(p => eye(...p)));
    const c = eye(...centre);
    box = [c[0] - ball, c[1] - ball, c[0] + ball, c[1] + ball];
  }
  const centre = [0, 0, 0];
  if (data.camera) {
    const lo = [Infinity, Infinity, Infinity], hi = [-Infinity, -Infinity, -Infinity], corners = [];
    const reach = (f, i, sign, o) => [0, 1, 2].map(k => o === undefined ? f[3 * i + k] : f[3 * o + k] + sign * (f[3 * i + k] - f[3 * o + k]));
    for (const f of data.frames) {
      for (let i = 0; 3 * i < f.length; ++i) corners.push(reach(f, i));
      for (const s of data.shapes) if (s.kind === 'ellipse') for (const end of [1, 2]) corners.push(reach(f, s.points[end], -1, s.points[0]));
    }
    data.backdrop.forEach(l => corners.push(...l));
    for (const p of corners) for (const k of [0, 1, 2]) { lo[k] = Math.min(lo[k], p[k]); hi[k] = Math.max(hi[k], p[k]); }
    for (const k of [0, 1, 2]) centre[k] = (lo[k] + hi[k]) / 2;
    for (const p of corners) ball = Math.max(ball, Math.hypot(p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]));
    [side, above] = data.camera;
    const from = /[#&]view=([-+.\deE]+),([-+.\deE]+)/.exec(location.hash);  // page.html#view=40,10 opens with that camera
    if (from) { side = Number(from[1]); above = Number(from[2]); }
    look();
    canvas.style.cursor = 'grab'; canvas.style.touchAction = 'none';
    let grip = [0, 0];
    canvas.addEventListener('pointerdown', e => { canvas.setPointerCapture(e.pointerId); grip = [e.clientX, e.clientY]; });
    canvas.addEventListener('pointermove', e => {
      if (!(e.buttons & 1)) return;
      turn((grip[0] - e.clientX) / 2, (e.clientY - grip[1]) / 2);
      grip = [e.clientX, e.clientY];
    });
  } else findBox();
  function turn(right, up) { side = (side + right) % 360; above = Math.max(-90, Math.min(90, above + up)); look(); resize(); }

  const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  let ink, muted, rule, card, series;
  function readTheme() {
    ink = css('--ink'); muted = css('--muted'); rule = css('--rule'); card = css('--card');
    series = [...Array(8).keys()].map(i => css('--s' + i));
  }
  const colour = s => s.colour < 0 ? muted : series[s.colour % 8];

  function resize() {
    const ratio = window.devicePixelRatio || 1;
    width = canvas.clientWidth; height = canvas.clientHeight;
    canvas.width = Math.round(width * ratio); canvas.height = Math.round(height * ratio);
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const margin = 24, w = box[2] - box[0], h = box[3] - box[1];
    zoom = Math.min((width - 2 * margin) / Math.max(w, 1e-3 * h, 1e-300), (height - 2 * margin) / Math.max(h, 1e-3 * w, 1e-300));
    shiftX = width / 2 - zoom * (box[0] + box[2]) / 2;
    shiftY = height / 2 + zoom * (box[1] + box[3]) / 2;
    draw();
  }
  const X = x => shiftX + zoom * x, Y = y => shiftY - zoom * y;

  function frameBefore(t) {
    let lo = 0, hi = last;
    while (hi - lo > 1) { const mid = (lo + hi) >> 1; if (times[mid] <= t) lo = mid; else hi = mid; }
    return lo;
  }

  function coil(ax, ay, bx, by) {
    const length = Math.hypot(bx - ax, by - ay) || 1, ux = (bx - ax) / length, uy = (by - ay) / length;
    const turns = 9, lead = Math.min(12, 0.12 * length), amplitude = 7;
    pen.moveTo(ax, ay); pen.lineTo(ax + ux * lead, ay + uy * lead);
    for (let i = 0; i < 2 * turns; ++i) {
      const s = lead + (length - 2 * lead) * (i + 0.5) / (2 * turns), side = (i % 2 ? -1 : 1) * amplitude;
      pen.lineTo(ax + ux * s - uy * side, ay + uy * s + ux * side);
    }
    pen.lineTo(bx - ux * lead, by - uy * lead); pen.lineTo(bx, by);
  }

  function drawTrail(s, upto, p) {
    const k = 2 * s.points[0], first = s.size > 0 ? frameBefore(Math.max(start, now - s.size)) : 0;
    const pieces = s.size > 0 ? 24 : 1, count = upto - first;
    pen.strokeStyle = colour(s); pen.lineWidth = 1.6;
    for (let piece = 0; piece < pieces; ++piece) {
      const from = first + Math.floor(count * piece / pieces), to = first + Math.floor(count * (piece + 1) / pieces);
      pen.globalAlpha = s.size > 0 ? 0.75 * (piece + 1) / pieces : 0.5;
      pen.beginPath();
      for (let i = from; i <= to; ++i) pen.lineTo(X(frames[i][k]), Y(frames[i][k + 1]));
      if (piece === pieces - 1) pen.lineTo(X(p[k]), Y(p[k + 1]));
      pen.stroke();
    }
    pen.globalAlpha = 1;
  }

  function draw() {
    const i = frameBefore(now), a = frames[i], b = frames[Math.min(i + 1, last)];
    const span = times[Math.min(i + 1, last)] - times[i], w = span > 0 ? Math.min(1, (now - times[i]) / span) : 0;
    const p = a.map((v, k) => v + w * (b[k] - v)), px = n => X(p[2 * n]), py = n => Y(p[2 * n + 1]);
    pen.clearRect(0, 0, width, height);
    pen.lineJoin = pen.lineCap = 'round';
    pen.strokeStyle = muted; pen.globalAlpha = 0.55; pen.lineWidth = 1.5;
    for (const l of backdrop) { pen.beginPath(); l.forEach(q => pen.lineTo(X(q[0]), Y(q[1]))); pen.stroke(); }
    pen.globalAlpha = 1;
    for (const s of data.shapes) {
      const n = s.points[0];
      pen.beginPath();
      if (s.kind === 'trail') drawTrail(s, i, p);
      else if (s.kind === 'line') {
        pen.strokeStyle = s.colour < 0 ? ink : colour(s); pen.lineWidth = 2.4;
        s.points.forEach(m => pen.lineTo(px(m), py(m))); pen.stroke();
      } else if (s.kind === 'spring') {
        pen.strokeStyle = muted; pen.lineWidth = 1.6; coil(px(n), py(n), px(s.points[1]), py(s.points[1])); pen.stroke();
      } else if (s.kind === 'disk') {
        pen.fillStyle = colour(s); pen.strokeStyle = card; pen.lineWidth = 2;
        pen.arc(px(n), py(n), s.size, 0, 7); pen.fill(); pen.stroke();
      } else if (s.kind === 'pivot') {
        pen.fillStyle = card; pen.strokeStyle = ink; pen.lineWidth = 2; pen.arc(px(n), py(n), 4, 0, 7); pen.fill(); pen.stroke();
      } else if (s.kind === 'box') {
        pen.fillStyle = s.colour < 0 ? rule : colour(s); pen.strokeStyle = ink; pen.lineWidth = 1.6;
        pen.rect(px(n) - zoom * s.size / 2, py(n) - zoom * s.size2 / 2, zoom * s.size, zoom * s.size2); pen.fill(); pen.stroke();
      } else if (s.kind === 'ellipse') {
        const [c, u, v] = s.points;
        pen.strokeStyle = colour(s); pen.lineWidth = 1.6;
        for (let k = 0; k <= 96; ++k) {
          const f = 2 * Math.PI * k / 96, x = Math.cos(f), y = Math.sin(f);
          pen.lineTo(px(c) + x * (px(u) - px(c)) + y * (px(v) - px(c)), py(c) + x * (py(u) - py(c)) + y * (py(v) - py(c)));
        }
        pen.stroke();
      } else if (s.kind === 'arrow') {
        const m = s.points[1], dx = px(m) - px(n), dy = py(m) - py(n), length = Math.hypot(dx, dy), head = Math.min(9, length);
        if (length < 1) continue;
        const ux = dx / length * head, uy = dy / length * head;
        pen.strokeStyle = pen.fillStyle = colour(s); pen.lineWidth = 2.2;
        pen.moveTo(px(n), py(n)); pen.lineTo(px(m) - 0.8 * ux, py(m) - 0.8 * uy); pen.stroke(); pen.beginPath();
        pen.moveTo(px(m), py(m)); pen.lineTo(px(m) - ux - 0.45 * uy, py(m) - uy + 0.45 * ux); pen.lineTo(px(m) - ux + 0.45 * uy,
                                                                                                         py(m) - uy - 0.45 * ux); pen.fill();
      }
    }
    scrub.value = String((now - start) / (end - start));
    clock.textContent = 't = ' + now.toFixed(decimals) + (data.unit ? ' ' + data.unit : '');
    cursors.forEach(move => move(now));
  }

  // Cursors in the plots, and a click in a plot to go there.
  const cursors = [...document.querySelectorAll('svg[data-time]')].map(svg => {
    const [left, right, top, bottom, from, to] = svg.dataset.time.split(' ').map(Number);
    const line = document.createElementNS('http://www.w3.org/2000/svg', 'line');
    line.setAttribute('class', 'cursor'); line.setAttribute('y1', top); line.setAttribute('y2', bottom);
    svg.appendChild(line);
    const go = e => {
      const r = svg.getBoundingClientRect(), x = (e.clientX - r.left) / r.width * svg.viewBox.baseVal.width;
      now = Math.min(end, Math.max(start, from + (x - left) / (right - left) * (to - from))); draw();
    };
    svg.addEventListener('pointerdown', e => { pause(); go(e); });
    svg.addEventListener('pointermove', e => { if (e.buttons & 1) go(e); });
    return t => {
      const x = left + (t - from) / (to - from) * (right - left);
      line.setAttribute('x1', x); line.setAttribute('x2', x);
    };
  });

  const icon = d => '<svg viewBox="0 0 14 14"><path d="' + d + '"/></svg>';
  function pause() { playing = false; play.innerHTML = icon('M3 1l9 6-9 6z'); play.setAttribute('aria-label', 'Play'); }
  function go() {
    if (now >= end) now = start;
    playing = true; before = 0; play.innerHTML = icon('M2 1h4v12H2zM8 1h4v12H8z'); play.setAttribute('aria-label', 'Pause');
    requestAnimationFrame(tick);
  }
  function tick(ms) {
    if (!playing) return;
    if (before) now += (ms - before) / 1000 * data.rate * Number(speed.value);
    before = ms;
    if (now >= end) { now = end; pause(); }
    draw();
    if (playing) requestAnimationFrame(tick);
  }
  play.onclick = () => playing ? pause() : go();
  scrub.oninput = () => { pause(); now = start + Number(scrub.value) * (end - start); draw(); };
  document.addEventListener('keydown', e => {
    if (e.target instanceof HTMLSelectElement || e.target === scrub) return;
    if (e.key === ' ') { if (e.target !== play) { e.preventDefault(); play.onclick(); } }
    else if (data.camera && e.shiftKey && e.key.startsWith('Arrow')) {
      e.preventDefault(); turn(5 * ((e.key === 'ArrowRight') - (e.key === 'ArrowLeft')), 5 * ((e.key === 'ArrowUp') - (e.key === 'ArrowDown')));
    } else if (e.key === 'ArrowRight' || e.key === 'ArrowLeft') {
      pause(); now += (e.key === 'ArrowRight' ? 1 : -1) * (end - start) / 200;
      now = Math.min(end, Math.max(start, now)); draw();
    }
  });
  readTheme();
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { readTheme(); draw(); });
  new ResizeObserver(resize).observe(canvas);
  resize();
  const wanted = /[#&]t=([-+.\deE]+)/.exec(location.hash);  // page.html#t=2.5 opens at that time
  if (wanted) { now = Math.min(end, Math.max(start, Number(wanted[1]))); pause(); draw(); }
  else if (matchMedia('(prefers-reduced-motion: reduce)').matches) pause();
  else go();
})();
)js";

}  // namespace qdot::report::detail
