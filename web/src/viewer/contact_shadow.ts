import {
  DoubleSide,
  Group,
  HalfFloatType,
  Mesh,
  MeshBasicMaterial,
  MeshDepthMaterial,
  OrthographicCamera,
  PlaneGeometry,
  type Scene,
  ShaderMaterial,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { HorizontalBlurShader } from "three/addons/shaders/HorizontalBlurShader.js";
import { VerticalBlurShader } from "three/addons/shaders/VerticalBlurShader.js";

const SIZE = 2.6;
const HEIGHT = 0.5;
const RESOLUTION = 384;

/**
 * A soft shadow where the figure meets the ground: the scene's depth seen from below, blurred twice.
 * Drawn again only when the figure has changed.
 */
export class ContactShadow {
  readonly group = new Group();
  private readonly camera = new OrthographicCamera(-SIZE / 2, SIZE / 2, SIZE / 2, -SIZE / 2, 0, HEIGHT);
  private readonly target = new WebGLRenderTarget(RESOLUTION, RESOLUTION, { type: HalfFloatType });
  private readonly scratch = new WebGLRenderTarget(RESOLUTION, RESOLUTION, { type: HalfFloatType });
  private readonly depth = depthMaterial();
  private readonly horizontal = new ShaderMaterial({ ...HorizontalBlurShader, depthTest: false });
  private readonly vertical = new ShaderMaterial({ ...VerticalBlurShader, depthTest: false });
  private readonly blurPlane = new Mesh(new PlaneGeometry(SIZE, SIZE).rotateX(Math.PI / 2));
  private readonly plane: Mesh<PlaneGeometry, MeshBasicMaterial>;

  constructor() {
    const material = new MeshBasicMaterial({ map: this.target.texture, transparent: true, depthWrite: false });
    this.plane = new Mesh(this.blurPlane.geometry, material);
    this.plane.scale.y = -1;
    this.plane.renderOrder = -1;
    this.camera.rotation.x = Math.PI / 2;
    this.blurPlane.visible = false;
    this.group.add(this.plane, this.camera, this.blurPlane);
  }

  render(renderer: WebGLRenderer, scene: Scene): void {
    const alpha = renderer.getClearAlpha();
    const shadows = renderer.shadowMap.needsUpdate;
    renderer.shadowMap.needsUpdate = false;
    this.plane.visible = false;
    scene.overrideMaterial = this.depth;
    renderer.setClearAlpha(0);
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(scene, this.camera);
    scene.overrideMaterial = null;
    this.blur(renderer, 2.4);
    this.blur(renderer, 1);
    renderer.setRenderTarget(null);
    renderer.setClearAlpha(alpha);
    renderer.shadowMap.needsUpdate = shadows;
    this.plane.visible = true;
  }

  dispose(): void {
    for (const part of [this.target, this.scratch, this.depth, this.horizontal, this.vertical]) part.dispose();
    this.plane.geometry.dispose();
    this.plane.material.dispose();
  }

  private blur(renderer: WebGLRenderer, amount: number): void {
    this.blurPlane.visible = true;
    const passes = [
      { material: this.horizontal, uniform: "h", from: this.target, to: this.scratch },
      { material: this.vertical, uniform: "v", from: this.scratch, to: this.target },
    ];
    for (const { material, uniform, from, to } of passes) {
      const uniforms = material.uniforms;
      if (uniforms.tDiffuse) uniforms.tDiffuse.value = from.texture;
      const step = uniforms[uniform];
      if (step) step.value = amount / RESOLUTION;
      this.blurPlane.material = material;
      renderer.setRenderTarget(to);
      renderer.render(this.blurPlane, this.camera);
    }
    this.blurPlane.visible = false;
  }
}

/** Black, the darker the nearer to the ground. */
function depthMaterial(): MeshDepthMaterial {
  const material = new MeshDepthMaterial({ side: DoubleSide });
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );",
      "gl_FragColor = vec4( vec3( 0.0 ), pow( 1.0 - fragCoordZ, 2.0 ) * 0.55 );",
    );
  };
  return material;
}
