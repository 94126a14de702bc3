'use strict';

const WIDTH = 320, HEIGHT = 256;
// Clean enough not to warm a lap any longer.
let lastPass = 512;

const form = document.querySelector('form');
const sliders = [...form.querySelectorAll('input[type=range]')];
const SHOWN = {
    lampAngle: value => value + '\u00b0',
    ballRadius: value => value.toFixed(2),
    index: value => value.toFixed(2),
    extinction: value => value.toFixed(3),
    photons: value => count(2 ** value),
    plainRadius: value => value.toFixed(3),
};

function count(number) {
    return Math.round(number).toLocaleString('en-US');
}

function settings() {
    const values = Object.fromEntries(sliders.map(slider => [slider.name, Number(slider.value)]));
    return { ...values, photons: 2 ** values.photons, seed: 1 };
}

// A picture, and the worker that renders it.
class Picture {
    constructor(id, adaptive) {
        const figure = document.getElementById(id);
        this.context = figure.querySelector('canvas').getContext('2d');
        this.counts = figure.querySelector('.counts');
        this.adaptive = adaptive;
        this.busy = false;
        this.restart();
    }

    start(module, next) {
        this.module = module;
        const source = new Blob(['"use strict";(' + renderer + ')()'], { type: 'text/javascript' });
        this.worker = new Worker(URL.createObjectURL(source));
        this.worker.onmessage = ({ data }) => {
            this.busy = false;
            if (data.generation === generation)
                this.receive(data);
            next();
        };
        this.worker.onerror = event => {
            failed = event.message;
            this.counts.textContent = 'The renderer has stopped: ' + event.message;
        };
    }

    restart() {
        this.passes = this.seconds = this.eyeRays = 0;
        this.radiance = null;
    }

    pass() {
        const { passes, adaptive, module } = this;
        const isLast = passes + 1 === lastPass;
        this.busy = true;
        this.module = null;
        this.worker.postMessage({ module, generation, passes, isLast, adaptive, width: WIDTH, height: HEIGHT,
            settings: settings() });
    }

    receive({ passes, seconds, eyeRays, shown, radiance }) {
        this.passes = passes;
        this.seconds += seconds;
        this.eyeRays = eyeRays;
        if (shown) {
            this.context.putImageData(new ImageData(shown, WIDTH, HEIGHT), 0, 0);
            this.radiance = radiance;
        }
        const each = this.seconds / passes;
        this.counts.innerHTML = `<b>${this.seconds.toFixed(1)} s</b> \u00b7 ${count(passes)} `
            + `${passes > 1 ? 'passes' : 'pass'} of ${each.toFixed(2)} s \u00b7 `
            + `<b>${count(passes * settings().photons)} photons</b> \u00b7 ${count(eyeRays / passes)} eye rays a pass`;
    }
}

let generation = 0, failed = null;
const plain = new Picture('plain', 0), covbeam = new Picture('covbeam', 1);
const pair = [[plain, covbeam], [covbeam, plain]];

// The one that is behind the other goes on, in passes or in seconds.
function next() {
    const measure = form.pace.value === 'time' ? 'seconds' : 'passes';
    for (const [one, other] of pair)
        if (!one.busy && !failed && !document.hidden && one.passes < lastPass && one[measure] <= other[measure])
            one.pass();
}

function changed() {
    for (const slider of sliders)
        slider.previousElementSibling.textContent = SHOWN[slider.name](Number(slider.value));
    generation++;
    plain.restart();
    covbeam.restart();
    if (plain.worker)
        next();
}

async function begin() {
    const bytes = Uint8Array.from(atob(MODULE), character => character.charCodeAt(0));
    const module = await WebAssembly.compile(bytes);
    plain.start(module, next);
    covbeam.start(module, next);
    next();
}

form.addEventListener('input', changed);
form.addEventListener('submit', event => event.preventDefault());
document.addEventListener('visibilitychange', next);
changed();
begin();
