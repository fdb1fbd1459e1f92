import {
  CanvasTexture,
  Color,
  DoubleSide,
  type Material,
  MeshPhysicalMaterial,
  MeshStandardMaterial,
  SRGBColorSpace,
  type Texture,
} from "three";

/** The look of one garment: its own material, a tint over it, or a heat map in its place. */
export class Cloth {
  private readonly own: MeshPhysicalMaterial;
  private tinted: MeshPhysicalMaterial | undefined;

  constructor(source: Material) {
    this.own = physical(source);
  }

  /** The material as the file has it, or tinted; `tint` is a CSS hex colour. */
  material(tint: string | undefined): MeshPhysicalMaterial {
    if (!tint) return this.own;
    this.tinted ??= weaveOnly(this.own);
    this.tinted.color.setStyle(tint, SRGBColorSpace);
    this.tinted.sheenColor.copy(this.tinted.color).lerp(new Color(1, 1, 1), 0.35);
    return this.tinted;
  }

  /** The colour that a picker shows for the untinted garment. */
  get ownColor(): string {
    return `#${this.own.color.getHexString(SRGBColorSpace)}`;
  }

  dispose(): void {
    for (const material of [this.own, this.tinted]) {
      material?.map?.dispose();
      material?.normalMap?.dispose();
      material?.dispose();
    }
  }
}

/** Matte mannequin skin. The offset keeps cloth that lies on the body from flickering through it. */
export function mannequinMaterial(): MeshPhysicalMaterial {
  return new MeshPhysicalMaterial({
    color: "#cdbcae",
    roughness: 0.62,
    metalness: 0,
    sheen: 0.25,
    sheenRoughness: 0.6,
    sheenColor: new Color("#f3e4d8"),
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
}

export function heatMaterial(): MeshStandardMaterial {
  return new MeshStandardMaterial({ vertexColors: true, roughness: 0.95, metalness: 0, side: DoubleSide });
}

function physical(source: Material): MeshPhysicalMaterial {
  const cloth = new MeshPhysicalMaterial({ side: DoubleSide, roughness: 0.85 });
  if (source instanceof MeshPhysicalMaterial) cloth.copy(source);
  else if (source instanceof MeshStandardMaterial) MeshStandardMaterial.prototype.copy.call(cloth, source);
  cloth.side = DoubleSide;
  cloth.vertexColors = false;
  if (cloth.sheen === 0) {
    cloth.sheen = 0.25;
    cloth.sheenRoughness = 0.45;
    cloth.sheenColor = cloth.color.clone().lerp(new Color(1, 1, 1), 0.35);
  }
  if (cloth.map) cloth.map.anisotropy = 8;
  return cloth;
}

/** A copy whose texture keeps the weave and loses the colour, so that a tint comes out as chosen. */
function weaveOnly(source: MeshPhysicalMaterial): MeshPhysicalMaterial {
  const copy = source.clone();
  copy.map = source.map ? greyWeave(source.map) : null;
  return copy;
}

/** The texture in grey, scaled to a mean of 0.9; null where the picture cannot be drawn. */
function greyWeave(texture: Texture): Texture | null {
  const image = texture.image as (CanvasImageSource & { width: number; height: number }) | undefined;
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!image || !context) return null;
  canvas.width = image.width;
  canvas.height = image.height;
  context.drawImage(image, 0, 0);
  const picture = context.getImageData(0, 0, canvas.width, canvas.height);
  equalize(picture.data);
  context.putImageData(picture, 0, 0);
  const weave = new CanvasTexture(canvas);
  weave.colorSpace = SRGBColorSpace;
  weave.flipY = texture.flipY;
  weave.channel = texture.channel;
  weave.wrapS = texture.wrapS;
  weave.wrapT = texture.wrapT;
  weave.repeat.copy(texture.repeat);
  weave.offset.copy(texture.offset);
  weave.rotation = texture.rotation;
  weave.anisotropy = 8;
  return weave;
}

/** Replaces RGBA bytes by their luma (ITU-R BT.709) relative to the mean, in place. */
export function equalize(bytes: Uint8ClampedArray): void {
  const luma = (index: number): number =>
    0.2126 * (bytes[index] ?? 0) + 0.7152 * (bytes[index + 1] ?? 0) + 0.0722 * (bytes[index + 2] ?? 0);
  let sum = 0;
  for (let index = 0; index < bytes.length; index += 4) sum += luma(index);
  const mean = Math.max(sum / (bytes.length / 4), 1);
  for (let index = 0; index < bytes.length; index += 4) {
    bytes.fill(Math.min(230 * (luma(index) / mean), 255), index, index + 3);
  }
}
