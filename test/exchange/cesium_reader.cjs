// Print as JSON what CesiumJS evaluates of a scene: node cesium_reader.cjs FILE ID EPOCH ...
//
// For each epoch position and quaternion of the entity, and longitude, latitude and height of
// its ground track; then the stop time of the clock.
// What a browser has, of which CesiumJS asks whether a value is one.
for (const name of ['Image', 'HTMLCanvasElement', 'HTMLImageElement', 'HTMLVideoElement',
  'ImageBitmap', 'OffscreenCanvas', 'ImageData']) globalThis[name] ??= class {};
const Cesium = require('cesium');
const [file, id, ...epochs] = process.argv.slice(2);

Cesium.CzmlDataSource.load(JSON.parse(require('fs').readFileSync(file))).then((scene) => {
  const entity = scene.entities.getById(id);
  const track = scene.entities.getById(`${id}/ground_track`);
  const rows = epochs.map((text) => {
    const at = Cesium.JulianDate.fromIso8601(text);
    const position = entity.position.getValue(at);
    const q = entity.orientation.getValue(at);
    const below = Cesium.Cartographic.fromCartesian(track.position.getValue(at));
    return [[position.x, position.y, position.z], [q.x, q.y, q.z, q.w],
      [below.longitude, below.latitude, below.height]];
  });
  console.log(JSON.stringify([rows, scene.clock.stopTime.toString()]));
}).catch((error) => { console.error(error); process.exit(1); });
