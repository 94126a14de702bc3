// The page of examples/web, by its module alone and in a browser:
//   node web.js module FOLDER PASSES            a line a method as examples/web's program `native` prints them
//   node web.js page FOLDER PROFILE PICTURE [measured]     in headless Chromium; writes a screenshot
'use strict';
const { spawn } = require('child_process');
const fs = require('fs');
const path = require('path');

const [, , mode, folder, ...rest] = process.argv;

function assert(holds, message) {
    if (!holds)
        throw new Error(message);
}

// FNV-1a of 64 bits.
function hash(bytes) {
    let value = 0xcbf29ce484222325n;
    for (const byte of bytes)
        value = ((value ^ BigInt(byte)) * 0x100000001b3n) & 0xffffffffffffffffn;
    return value.toString(16).padStart(16, '0');
}

function runModule(passes) {
    const text = fs.readFileSync(path.join(folder, 'module.js'), 'utf8').match(/'(.*)'/)[1];
    const wasm = new WebAssembly.Instance(new WebAssembly.Module(Buffer.from(text, 'base64'))).exports;
    for (const adaptive of [0, 1]) {
        wasm.begin(320, 256, adaptive, 52, 0.5, 1.5, 0.125, 1024, 0.03, 1);
        const start = performance.now();
        for (let pass = 0; pass < passes; pass++)
            wasm.pass();
        const seconds = (performance.now() - start) / 1000 / passes;
        const at = wasm.picture();
        console.log(adaptive, hash(new Uint8Array(wasm.memory.buffer, at, 320 * 256 * 12)), seconds.toFixed(3));
    }
}

// Chromium at the end of a pipe: calls of its DevTools protocol, and what it complains of.
class Browser {
    constructor(profile) {
        this.complaints = [];
        this.calls = new Map();
        this.process = spawn('chromium', ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
            '--disable-background-networking', '--disable-component-update', '--disable-sync', '--hide-scrollbars',
            '--host-resolver-rules=MAP * ~NOTFOUND', '--remote-debugging-pipe', '--user-data-dir=' + profile,
            'about:blank'], { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
        let left = '';
        this.process.stdio[4].setEncoding('utf8').on('data', data => {
            const messages = (left + data).split('\0');
            left = messages.pop();
            messages.map(text => JSON.parse(text)).forEach(message => this.receive(message));
        });
    }

    receive({ id, result, error, method, params }) {
        if (this.calls.has(id)) {
            const [resolve, reject] = this.calls.get(id);
            error ? reject(new Error(error.message)) : resolve(result);
        }
        if (['Runtime.exceptionThrown', 'Runtime.consoleAPICalled', 'Log.entryAdded'].includes(method))
            this.complaints.push(JSON.stringify(params).slice(0, 500));
        if (method === 'Network.requestWillBeSent' && !/^(file|blob|data):/.test(params.request.url))
            this.complaints.push('request: ' + params.request.url);
    }

    call(method, params = {}) {
        const id = this.calls.size + 1;
        const { sessionId } = this;
        this.process.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + '\0');
        return new Promise((resolve, reject) => this.calls.set(id, [resolve, reject]));
    }

    async open(url) {
        const { targetInfos } = await this.call('Target.getTargets');
        const { targetId } = targetInfos.find(target => target.type === 'page');
        this.sessionId = (await this.call('Target.attachToTarget', { targetId, flatten: true })).sessionId;
        for (const domain of ['Runtime', 'Log', 'Network', 'Page'])
            await this.call(domain + '.enable');
        await this.call('Page.navigate', { url });
    }

    async evaluate(expression) {
        const wanted = { expression, awaitPromise: true, returnByValue: true };
        const { result, exceptionDetails } = await this.call('Runtime.evaluate', wanted);
        assert(!exceptionDetails, expression + ': ' + JSON.stringify(exceptionDetails));
        return result.value;
    }

    async until(expression, seconds) {
        for (const end = Date.now() + 1000 * seconds; Date.now() < end;) {
            if (await this.evaluate(expression))
                return;
            await new Promise(resolve => setTimeout(resolve, 50));
        }
        throw new Error(`not within ${seconds} s: ${expression}`);
    }

    async screenshot(file, width, height) {
        await this.call('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: false });
        const { data } = await this.call('Page.captureScreenshot', { format: 'png' });
        fs.writeFileSync(file, Buffer.from(data, 'base64'));
    }
}

// What is asked of the page, in its own words.
const ASKED = `
function move(values) {
    for (const [name, value] of Object.entries(values))
        form[name].value = value;
    form.dispatchEvent(new Event('input'));
}
function extremes(end) {
    move(Object.fromEntries(sliders.map(slider => [slider.name, slider[end]])));
}
function passed(count) {
    return !failed && plain.passes >= count && covbeam.passes >= count;
}
// What a canvas shows, read from a copy that is made for reading.
function shown({ context }) {
    const copy = new OffscreenCanvas(WIDTH, HEIGHT).getContext('2d', { willReadFrequently: true });
    copy.drawImage(context.canvas, 0, 0);
    return copy.getImageData(0, 0, WIDTH, HEIGHT).data;
}
// Mean level, and how many pixels are as red as can be.
function levels(picture) {
    const data = shown(picture);
    const mean = data.filter((_, i) => i % 4 < 3).reduce((sum, level) => sum + level, 0) / (3 * WIDTH * HEIGHT);
    return [mean, data.filter((level, i) => i % 4 === 0 && level === 255).length];
}
// Radiance of many photons of another seed, with narrow kernels, a third worker's.
function reference(photons, passes) {
    const worker = new Worker(URL.createObjectURL(new Blob(['(' + renderer + ')()'])));
    const asked = { generation: 0, adaptive: 0, width: WIDTH, height: HEIGHT };
    asked.settings = { ...settings(), photons, plainRadius: 0.02, seed: 2 };
    const bytes = Uint8Array.from(atob(MODULE), character => character.charCodeAt(0));
    worker.postMessage({ ...asked, module: new WebAssembly.Module(bytes), passes: 0 });
    return new Promise(resolve => {
        worker.onmessage = ({ data }) => data.passes === passes ? resolve(data.radiance)
            : worker.postMessage({ ...asked, passes: data.passes, isLast: data.passes + 1 === passes });
    });
}
let truth = null;
// Relative mean squared error.
function error({ radiance }, reference) {
    const dark = 0.01 * reference.reduce((sum, value) => sum + value, 0) / reference.length;
    return reference.reduce((sum, value, i) => sum + (radiance[i] - value) ** 2 / (value ** 2 + dark ** 2), 0)
        / reference.length;
}
0`;

const ERRORS = '[plain, covbeam].map(picture => error(picture, truth))';

// How long a pass takes is the machine's: nothing is asserted.
async function compareTimes(browser) {
    await browser.evaluate("form.pace.value = 'time'; lastPass = 512; next()");
    await browser.until('covbeam.passes >= 24', 300);
    await browser.evaluate('lastPass = 0');
    await browser.until('!plain.busy && !covbeam.busy', 60);
    const [plain, covbeam] = await browser.evaluate(ERRORS);
    const passes = await browser.evaluate('`${plain.passes} and ${covbeam.passes}`');
    console.log(`error at equal time, ${passes} passes: plain ${plain.toFixed(4)}, covbeam ${covbeam.toFixed(4)}`);
}

async function lookAt(browser, picture, isMeasured) {
    await browser.open('file://' + path.resolve(folder, 'index.html'));
    await browser.until("document.readyState === 'complete' && typeof plain === 'object'", 60);
    await browser.evaluate(ASKED);
    await browser.evaluate('lastPass = 8; changed()');
    await browser.until('passed(8)', 200);
    await browser.screenshot(picture, 1200, 800);
    await browser.evaluate('lastPass = 16; next()');
    await browser.until('passed(16)', 300);
    const drawn = await browser.evaluate('[levels(plain), levels(covbeam)]');
    for (const [mean, white] of drawn)
        assert(mean > 10 && mean < 200 && white < 4000, `dark or white: ${drawn}`);

    const seconds = await browser.evaluate('[plain, covbeam].map(picture => picture.seconds / picture.passes)');
    await browser.evaluate(`reference(8192, ${isMeasured ? 12 : 4}).then(found => { truth = found; })`);
    const errors = await browser.evaluate(ERRORS);
    console.log(`in the browser: ${seconds.map(value => value.toFixed(2)).join(' and ')} s a pass, plain and covbeam`);
    console.log(`error at 16 passes of equal photons: plain ${errors[0].toFixed(4)}, covbeam ${errors[1].toFixed(4)}`);
    assert(errors[1] < 0.7 * errors[0], 'covbeam is no nearer to the reference than plain beams');
    if (isMeasured)
        await compareTimes(browser);

    // A slider moves: other pictures, from the first pass on.
    const before = await browser.evaluate('shown(covbeam).join()');
    await browser.evaluate("form.pace.value = 'photons'; lastPass = 2; move({ lampAngle: 120 })");
    await browser.until('passed(2)', 100);
    const after = await browser.evaluate('shown(covbeam).join()');
    assert(before !== after, 'the slider moves nothing');
    for (const end of ['min', 'max']) {
        await browser.evaluate(`extremes('${end}')`);
        await browser.until('passed(2)', 300);
        const sound = '[plain, covbeam].every(picture => picture.radiance.every(value => value >= 0 && value < 1e9))';
        assert(await browser.evaluate(sound), `all sliders at ${end}: numbers that are none`);
    }
    assert(browser.complaints.length === 0, browser.complaints.join('\n'));
}

async function main() {
    if (mode === 'module')
        return runModule(Number(rest[0]));
    const [profile, picture, measured] = rest;
    const browser = new Browser(profile);
    try {
        await lookAt(browser, picture, measured === 'measured');
    } finally {
        browser.process.kill();
    }
}

main().catch(failure => {
    console.error(failure.message);
    process.exitCode = 1;
});
