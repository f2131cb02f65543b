/* deepgbuffer.h - layered G-buffers and the shading they make possible - v0.1.0 - MIT or public domain

   Do this:
       #define DEEPGBUFFER_IMPLEMENTATION
   before you include this file in *one* C or C++ file. Everywhere else, include it without the define. Include
   deepgbuffer_gl.h after it for the OpenGL backend; the same define turns on both.

   You may define, before every include:
       DGB_API       prefix of public functions; default `extern`, may be `static`
       DGB_ASSERT(c) check of a programming error inside the library; default assert(c)

   WHAT IT IS
       A G-buffer that keeps, behind each visible surface, the next one that lies at least a *minimum separation*
       farther away. Built in one pass over your geometry. Ambient occlusion and bounced light then know what stands
       behind the columns: no halos, no light that vanishes when something walks in front of it.
       After "Deep G-Buffers for Stable Global Illumination Approximation", Mara, McGuire, Nowrouzezahrai, Luebke, 2016
       (called "the paper" below).

   WHAT IT DOES NOT DO
       - open windows, load files, own a scene graph, or know your materials: you draw, through a callback;
       - light your scene: you write or compute outgoing radiance, it gathers from that;
       - composite, tone-map or anti-alias: you get textures;
       - allocate memory, keep globals, start threads, print, or read the clock;
       - know any graphics API: that is the backend's work. deepgbuffer_gl.h is one, you can write another.

   QUICK START (every engine, every frame)
       dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
       dgb_build(&dgb, &view, &q, draw_scene, scene);         all layers, one pass over the geometry
       ...light the layers: write outgoing radiance into DGB_RADIANCE (or let your materials have done it)
       dgb_shade(&dgb, &q);                                   occlusion and bounced light
       ...composite with dgb_get_texture(&dgb, DGB_AO) and dgb_get_texture(&dgb, DGB_IRRADIANCE)
   With a depth buffer of your own and nothing else: set desc.source = DGB_SOURCE_ENGINE, call dgb_set_layers instead of
   dgb_build. examples/minimal.c is a whole program; examples/integrations/ is to copy from, ao_depth.c the shortest.

   STEP BY STEP
       1 init       Fill a dgb_desc (0 = default), call dgb_init. What was chosen is in context.plan.
       2 build      dgb_build calls you back with matrices to draw with: widened by the guard band, jittered. Draw every
                    opaque object once, as dgb_draw says. Alpha test before the keep test.
       3 light      Each layer is an image of the arrays DGB_DEPTH, DGB_ALBEDO, DGB_NORMAL: light it as you light your
                    own G-buffer and add the result to that layer of DGB_RADIANCE, or let the material shaders write lit
                    radiance in step 2. The image sits guard_band pixels inside the buffer; layers behind the first fill
                    width / divisor x height / divisor texels, texel q at pixel (q + 0.5) * divisor.
       4 shade      dgb_shade runs the passes that desc.effects asked for, once a frame. Called again on the same layers
                    it is a further frame in which nothing has moved: one bounce more, one set of taps more.
       5 composite  Yours; dgbgl_composite_snippet has the following in GLSL. For Lambert surfaces
                        final = emission + direct + albedo/pi * lerp(AV * E_probe, E, c)
                    AV from DGB_AO, E and its confidence from DGB_IRRADIANCE, c = min(2 confidence, 1), E_probe what you
                    have for light from elsewhere: a light probe, or a constant. (The paper takes c = confidence; twice
                    that is nearer to ray-traced light in every scene measured.) Mirrors and rough surfaces add
                        reflectance, or environment BRDF, * lerp(environment, L, confidence)
                    L and its confidence from DGB_REFLECTION. Results are as large as the buffer: pixel p of the image
                    is texel p + guard_band. Beyond the shaded part of the guard band (params.guard_fraction) they are
                    undefined, reflections beyond the image.
       A jump of the camera: view.cut. A new size: dgb_resize. At the end: dgb_shutdown.

   CONVENTIONS
       Camera space is right-handed and looks down -Z; lengths are metres (any unit will do if you use it everywhere).
       z is negative in front of the eye; functions give and take z = 0 for "no surface". Distance means -z.
       Matrices are float[16], column-major; vectors are columns. Pixels count from the lower left; centres are at +0.5.
       The projection is that of the image *without* guard band and without jitter; its clip-space z range and direction
       are stated once in the desc. Off-centre, orthographic, reversed and infinite projections are fine; oblique
       near planes and skew are refused.
       Radiance is outgoing, W/(m2 sr): albedo/pi * irradiance + emission. Irradiance is W/m2.
       Two rules for zero, never mixed: in dgb_desc 0 means "default"; in dgb_params 0 means 0, and dgb_preset fills
       them.

   DATA FLOW (the order of the code below, of shaders_embedded/ and of the tests)
       depth -> [warp]        WARP: last frame's depth from this frame's camera
       scene -> [layers]      depth, albedo, normal + material, radiance, velocity: 160 bits a pixel and layer
             -> [resolve]     IMAGE emission: depth bits of deeper layers become depth
             -> [back]        BACK_FACES: depth of the nearest back faces behind the first layer
             -> [predict]     PREDICT and DELAY: depth of the next pose
             -> [pack]        camera z and normals of two layers, radiance of each, with BOUNCES plus what last frame's
                              irradiance makes of it: 160 bits a pixel
             -> [mip]         chain made by copying one texel of four, never by averaging
             -> [tiles]       where the second layer can matter at all
             -> [ao]          ambient visibility, with BENT where it opens to
             -> [gather]      irradiance + confidence, with BOUNCES or REFLECT of both layers
             -> [temporal]    TEMPORAL: average over frames along the motion of each surface
             -> [reconstruct] separable bilateral filter over all of them
             -> [range]       HIERARCHICAL: depth ranges of both layers, over cells of 4, 8, 16... pixels
             -> [reflect]     what a mirror in each pixel would show, from both layers
             -> [glossy]      GLOSSY: what a rough surface would, from the rays of neighbours and of frames before
             -> your composite, and next frame's pack
       What desc.effects does not ask for has no texture, no pass and no program: dgb_make_plan shows it without a GPU.

   CHOOSING A CONSTRUCTION
       Three independent choices in the desc. dgb_make_plan shows what they cost in memory.
       oracle     what tells a fragment of layer j where layer j-1 is (paper, section 2):
                  PEEL       this frame's layer j-1. Exact; draws the scene once a layer.
                  PREVIOUS   last frame's layer j-1 at the same pixel. Wrong where anything moved.
                  REPROJECT  last frame's layer j-1 at the place where the point was then. Wrong only along silhouettes
                             of moving things. Needs previous positions of every vertex. The default.
                  PREDICT    a depth-only pass of the frame before, drawn with a guess of this frame's pose. As good as
                             the guess; 2 (k-1) more depth layers.
                  DELAY      the same with the true pose, by showing everything one frame late. Exact for layer 1;
                             deeper layers err under motion as PREVIOUS does.
                  WARP       last frame's layer j-1 as this frame's camera would have seen it: a full-screen pass a
                             layer, after which each pixel looks at itself. Wrong by up to half a texel along
                             silhouettes, and where objects move by themselves, which it takes to stand still. The
                             closest to PEEL of those that draw each pose once; the least memory; needs no previous
                             positions.
       emission   how one submission reaches all layers:
                  SEPARATE            one draw callback a layer
                  VERTEX              instances times layers; the vertex shader picks the layer
                  GEOMETRY            the geometry shader emits each triangle to every layer, in a loop
                  INSTANCED_GEOMETRY  the same, one invocation a layer
                  IMAGE               one plain rasterisation; a fragment that a deeper layer keeps competes for it in
                                      images, by its depth bits. Every vertex is shaded once and nothing is amplified.
                                      Only where fragments of a pixel are ordered: fragment shader interlock, or a
                                      rasteriser known to run them in order. No early depth test for layer 0.
                  MULTICAST           NVIDIA's viewport multicast behind a pass-through geometry shader. Validated by a
                                      compiler, never run by the authors.
                  AUTO picks by capability (on a software rasteriser IMAGE, the fastest there in large scenes) and says
                  in the plan what it picked. dgbgl_calibrate picks by measuring your scene on your device.
       divisor    resolution of the layers behind the first: 1, 1/2 or 1/4 in each direction.
       The first frame, and the frame after a cut or a resize, is always built by peeling, so no layer is ever unfilled.
       While nothing moves every oracle gives what PEEL gives, bit for bit, by every emission that does not clip
       (GEOMETRY, INSTANCED_GEOMETRY, and any single pass with a divisor, move the last bits of depth).
       With strict separation (params, on in every preset) the pack pass empties each layer-1 texel that is not more
       than the minimum separation behind the true layer 0: what the oracle got wrong becomes a hole, never a lie.

   CHOOSING QUALITY
       (The README's "Tune it" goes by what you see: noise, flicker, halos, leaks, borders. `make bench` measures the
       cost of each choice.)
       Set three lengths to your scene first: separation (what lies behind a column is about that far behind: 0.5 m in
       rooms and courts), ao_radius (the size of a crease that should darken) and radius (how far light bounces).
       Then take a preset, the paper's Table 2. Every number can be changed from frame to frame without compiling
       anything.
       taps         samples and ao_samples reduce noise, filter_taps hide it. normal_test removes light from surfaces
                    that face away. min_level trades noise for cache hits. guard_fraction matters to light that bounces
                    on. adaptive leaves out work, never results.
       estimator    (desc) what AO and RADIOSITY compute.
                    PAPER    the paper's equations, tuned by ao_bias, ao_epsilon, senders and normaliser. Confidence is
                             the share of the taps within the radius that found a sender.
                    BITMASK  which share of the cosine-weighted hemisphere nearby surfaces cover (Therrien et al. 2023,
                             here of two layers). Nearer surfaces hide what is behind them, nothing sends through
                             anything, and confidence is the share that is covered: the rest is the probe's. Visibility
                             is that of rays of the length ao_radius, without a falloff; ao_bias and ao_epsilon have no
                             say. The taps are shared among `slices` planes through the line of sight: one slice is
                             noisy in a frame and meant for TEMPORAL; more of them lessen the noise. With normal_test a
                             sender stands for the whole step around it, along its plane; without, light leaks past
                             surfaces thinner than the step. What neither begins nor ends within the radius hides
                             nothing; what lies beyond the buffer neither hides nor sends.
       thickness    (desc) what ends an object behind its surface. params.thickness (BITMASK) and reflect_thickness are
                    the most; objects of the first layer end sooner:
                    LAYERS      where the second layer begins;
                    BACK_FACES  there, or at the nearest back face behind the first layer, but not before a quarter of
                                the most. Rays pass behind thin things, and the most can be several times longer (1 m in
                                rooms). Takes one more draw of the scene, of depth alone, whatever the emission
                                (dgb_draw.back_faces; alpha test as ever), a depth texture and 8 bytes a pixel more of
                                DGB_Z. Right for closed objects; behind open ones lies the back of another, or none:
                                then the most holds;
                    CONSTANT    not at all: to compare with.
       senders      (desc, PAPER) BOTH, the default, is the paper's text: each accepted surface counts. STRONGEST counts
                    the brighter of the two, so dark surfaces behind bright ones take nothing away; the picture gets
                    lighter, not more accurate.
       normaliser   (desc, PAPER) BOUNDED, the default: a point never gets more than the brightest sender would give
                    from everywhere. PAPER is Equation 4 and can give twice that.
       BOUNCES      adds a bounce a frame, from the irradiance of the frame before in both layers (paper, section 3.3).
                    What is hidden receives and sends as well, so light finds its way around the corner. bounce_damping
                    below 1 lets light that has gone fade sooner, and darkens; the boosts emphasise coloured light,
                    against the conservation of energy.
       TEMPORAL     averages over frames, each of which takes other taps. history_weight 0.85 is the paper's advice:
                    more is smoother and lags behind moving lights; at 0.98 what BITMASK finds is nearly still. A
                    surface that has just come into view averages the frames that it has. Velocities tell where a
                    surface's history lies; it is checked against both layers of last frame, within history_tolerance of
                    the distance or history_floor: a surface that steps out from behind another keeps its light.
                    history_clamp keeps the history of surfaces that move within what this frame's neighbours found: 1
                    to 3 shortens trails and adds noise. sample_clamp, 2 to 10, takes out single bright samples, and
                    their light with them: the picture gets darker where few taps find a lamp. First frames, cuts, new
                    sizes, and other radii, biases or separations start afresh; other presets go on with the history.
                    Both filters weigh light by its confidence: a pixel whose taps found nothing says nothing.
       BENT         with AO and BITMASK, says where a point is open to: the cosine-weighted mean of the open directions,
                    in world space. Its direction is the bent normal; its length, over the open share beside it, tells
                    how wide the opening is (dgb_bent_cosine). Of an open point it is 2/3 of the normal, exactly. A
                    probe that is looked up there lights a corner under a window from the window: dgb_bent_direction and
                    dgb_probe_visible of the composite snippet.
       REFLECT      marches one mirrored ray a pixel. What passes in front of an object does not take it out of the
                    mirror. A ray that hits nothing has confidence 0: your environment map's turn. reflect_stride 1
                    follows every pixel; longer steps are cheaper and look for the hit within the step. Mirrored
                    surfaces show what they send, and with RADIOSITY what they make of bounced light, albedo/pi *
                    confidence * E: last frame's with BOUNCES, else this frame's. (That needs ALBEDO. Light from a probe
                    is not known here: add to DGB_RADIANCE what should be mirrored of it.)
       tracer       (desc) LINEAR tests every step of a ray. HIERARCHICAL leaves out steps of which the depth ranges of
                    cells tell that they hit nothing, and finds the very same hits: the longer the rays and the shorter
                    the steps, the more it saves.
       GLOSSY       turns the mirror of each pixel into that of one microfacet, of the perceptual roughness in the blue
                    channel of DGB_NORMAL (dgb_layers.roughness), and averages over the rays of glossy_taps neighbours
                    on the same surface. The result is the average radiance of the lobe D(h) G1(v) / (4 n.v), by which
                    your environment map should be prefiltered and which your environment BRDF multiplies (split sum).
                    Confidence is the share of the lobe that hits something. Roughness 0 is the mirror, exactly. With
                    TEMPORAL frames are averaged as well, by history_weight, along the motion of the surface, and the
                    less the farther the mirrored image, which moves otherwise, has slid beyond what the lobe blurs.
                    Another reflect_distance, reflect_thickness or separation starts afresh. What moves in the mirror of
                    a surface that stands still lags behind.

   WRITING A BACKEND
       Fill a dgb_backend with `version = DGB_VERSION`, the caps, and the callbacks. The library calls, between
       `begin` and `end` (both optional: save and restore the host's state there):
           texture_create / texture_destroy, program_create / program_destroy      in dgb_init, dgb_resize, dgb_shutdown
           pass_begin, texture_bind*, uniforms_upload, draw_fullscreen, pass_end       a full-screen pass
           pass_begin, texture_bind*, uniforms_upload, <your draw callback>, pass_end  a pass of your geometry
       A create callback returns DGB_OK and a handle whose id is not 0, or an error and nothing. When pass_begin returns
       an error, of that call only `end` still runs. `end` returns what else the device refused in the passes between
       `begin` and it; what a create callback has returned already it does not repeat. Textures bound to a pass are
       named by slot; the program of pass p is described by dgb_program_desc (pass + defines) and needs exactly the
       slots and outputs that the plan lists for p. uniforms_upload hands a std140 struct (dgb_*_uniforms below) that is
       valid until the call returns. Handles are opaque to the library; 0 is none.
       What a pass wants of the device is all in dgb_pass: targets with level and layer (-1: all layers at once),
       viewport, clearing, depth direction. Layered passes (LAYERS, BACK, PREDICT) draw with the depth test on; WARP and
       RESOLVE write depth from a full-screen triangle; the others have no depth. caps.emission says what the backend
       can do; SEPARATE is enough.
       examples/integrations/custom_rhi.c is one to start from, tests/support/record_backend.c one without a device.

   NUMERICAL GUARANTEES (unit tests hold every row)
       Every function of the mathematics takes any bits: it returns, nothing on the way is undefined behaviour, and the
       result is finite where no row says otherwise. Without contraction (-ffp-contract=off) gcc and clang give the same
       bits with -O0, -O2 and -O3; with -ffast-math what is exact in integers still does, and the rest stays finite and
       in range. Errors are relative where no unit is given; `-:` is what minus infinity, or a negative number, gives.
       function                error                       at 0             NaN           infinity       subnormal
       dgb_oct16_encode        0.957 deg, axes exact       +Z               +Z            +Z             +Z
       dgb_oct16_decode        length within 2.4e-7 of 1
       dgb_pack_normals        as dgb_oct16_encode
       dgb_unpack_normals      as dgb_oct16_decode
       dgb_storable            exact                       0                0             64512; -: 0    kept; -: 0
       dgb_r11g11b10f_pack     2^-7 (r, g), 2^-6 (b)       0                0             64512; -: 0    0
       dgb_r11g11b10f_unpack   exact                       0                its code's    its code's     -
       dgb_half_from_float     2^-11                       0, signed        0             +-65504        0, signed
       dgb_half_to_float       exact                       0, signed        its code's    its code's     -
       dgb_dithered            on average over u 1e-6      0                stays         stays          0
       dgb_spiral_turns        exact minimiser to 256      0, as for n < 1
       dgb_spiral_tap          1 ulp                       outside 0..n-1: {1, 0, 0}
       dgb_rotation            1 ulp                       {1, 0}
       dgb_pixel_hash          exact, same in GLSL
       dgb_pixel_pair          exact, same in GLSL
       dgb_hilbert_index       exact, same in GLSL
       dgb_pixel_quad          exact, same in GLSL
       dgb_mip_level           exact                       least            least         most; -: least least
       dgb_mip_levels          exact                       1, as for less
       dgb_mip_source          exact
       dgb_camera_from_matrix  see dgb_linear_z            refused          refused       refused        refused
       dgb_widen_projection    1 ulp                       stays            stays         stays          -
       dgb_depth_code          half a code                 0                stays         stays          0
       dgb_linear_z            6e-7, orthographic of far   see above it     0             0              as 0
       dgb_separation_limit    1e-3                        0                0             everywhere     0
       dgb_position            4e-7 of the terms           -                stays         stays          -
       dgb_pixels_per_metre    3e-7                        0                0             0              infinity
       dgb_keep_test           of the float sum: exact     front 0: false   false         farthest       -
       dgb_ao_term             a few ulp                   0                0             0              as 0
       dgb_ambient_visibility  a few ulp                   1                1             0; -: 1        1
       dgb_gather_term         a few ulp                   0                0             0              as 0
       dgb_gather_scale        a few ulp                   count 0: 0       as 0          0              as 0
       dgb_boost               a few ulp                   unsaturated      left out      unsaturated    -
       dgb_bilateral_weight    a few ulp                   normals alone    0             0              as 0
       dgb_arc_sine            6.8e-5                      6.8e-5           NaN           that of +-1    as 0
       dgb_slice_along         2 ulp                       +X               +X            +X             +X
       dgb_slice               6.8e-5 of angles            facing           facing        facing         facing
       dgb_slice_share         4.4e-3                      1                1             1              1
       dgb_sectors             exact                       -                first end     none           as 0
       dgb_sector_count        exact                       0
       dgb_slice_angle         1e-3                        0                horizon       horizon; -: 0  as 0
       dgb_slice_sum           1e-5, angles 0..pi          {0, 0}           NaN           NaN            as 0
       dgb_sectors_mean        1e-3                        {0, 0}
       dgb_bent_cosine         1e-5, at 0 1e-3             not open: 1      0; a: 1       1              -
       dgb_ggx_alpha           exact square                0                0             1; -: 0        0
       dgb_ggx_normal          see above it                n                v, n or +Z    v, n or +Z     -
       dgb_ggx_density         a few ulp                   0                0             0              0
       Devices may truncate where dgb_r11g11b10f_pack rounds: a stored radiance is up to one code lower.

   THREADS
       No globals. Math functions are pure. One context is used by one thread at a time, on the thread of its device.

   ERRORS
       Every call that can fail returns a dgb_result and has checked everything before it changes anything. The reason
       is a dgb_log_item and one sentence, given to desc.log. A context that is null or not live gives DGB_INVALID and
       no sentence: it has no log. When the device fails in dgb_build, the layers are lost; when it fails in dgb_shade,
       the history and the results are. The next call starts afresh.

   LIMITS
       Shading reads the first two layers, however many are built. Positions beyond 1e15 m count as sky.
       Far away, a depth format cannot resolve the separation (dgb_separation_limit): with a near plane at 0.1 m, half a
       metre is resolved up to 57 m in D16, 916 m in D24 and D32F, some 4 million metres in D32F with reversed depth.
       No tap is farther from its pixel than the buffer's diagonal, however large the radius is in pixels.
       A new size keeps the programs and nothing else: dgb_resize makes every texture anew before it lets go of the old
       ones, and the frame after it is as the first: peeled, without history or bounces. That is right for a window that
       is dragged. A resolution that follows the load should change seldom, or have a context for each of a few sizes,
       with programs and memory of its own and view.cut in its first frame after another's turn.
       The velocities of DGB_VELOCITY carry no depth: the history of an object that moves towards the eye and not across
       the image is rejected.

   VERSION HISTORY
       0.1.0  every oracle and emission, 1 to 8 layers; ambient occlusion, many bounces, temporal filter,
              reconstruction, mirror and glossy reflections; visibility bitmask, bent directions, thickness by back
              faces; OpenGL backend
*/

#ifndef DEEPGBUFFER_H
#define DEEPGBUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef DGB_API
#define DGB_API extern
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define DGB_VERSION_MAJOR 0
#define DGB_VERSION_MINOR 1
#define DGB_VERSION_PATCH 0
#define DGB_VERSION_STRING "0.1.0"
#define DGB_VERSION (DGB_VERSION_MAJOR * 10000 + DGB_VERSION_MINOR * 100 + DGB_VERSION_PATCH)

/* --- limits ------------------------------------------------------------------------------------------------------ */

#define DGB_MAX_SIZE 16384       /* pixels along one side, guard band included */
#define DGB_MAX_LAYERS 8         /* layers that can be built */
#define DGB_MAX_SHADED_LAYERS 2  /* layers that the shading reads */
#define DGB_MAX_TAPS 256         /* taps of one spiral */
#define DGB_MAX_LEVELS 6         /* levels of the packed MIP chain, level 0 included */
#define DGB_MAX_FILTER_RADIUS 12 /* reconstruction taps on one side of the centre */
#define DGB_MAX_DISTANCE 1e15f   /* metres; farther is sky */
#define DGB_EMPTY_Z (-1e15f)     /* what DGB_Z holds where there is no surface: so far away that it reaches nothing */
#define DGB_MIN_RADIUS 1e-15f    /* metres; of occlusion and bounced light */
#define DGB_MAX_RADIUS 1e14f
#define DGB_MAX_RADIANCE 64512.0f /* largest value of the 10-bit float, the narrowest channel stored to */
#define DGB_MIN_COSINE 0.017f     /* light that grazes a receiver within the error of an Oct16 normal is not counted */
#define DGB_MIN_ROUGHNESS (1.0f / 512.0f) /* below it a surface is a mirror; a byte above 0 is rougher */
#define DGB_MAX_GLOSSY_TAPS 32            /* neighbours whose rays a pixel takes into account */
#define DGB_MAX_SLICES 8                  /* of the visibility bitmask */
#define DGB_ROTATION_COUNT 256            /* rotations of the spiral */
#define DGB_TILE_SIZE 16                  /* pixels along one side of a tile */
#define DGB_REGION_SIZE 128               /* of a region: 8 x 8 tiles */
#define DGB_CELL_SIZE 4                   /* pixels along one side of a cell of the finest depth ranges */
#define DGB_AO_LOG2_Q 3                   /* AO taps within 2^3 = 8 pixels read level 0 (method of the paper, q) */
#define DGB_GATHER_LOG2_Q 4               /* radiosity taps within 2^4 = 16 pixels read level 0 */
#define DGB_MAX_TARGETS 4                 /* colour targets of one pass */
#define DGB_MAX_INPUTS 14                 /* textures read by one pass */
#define DGB_MAX_DEFINES 8                 /* of one program */
#define DGB_MAX_PROGRAMS 19               /* of one plan, like the next two */
#define DGB_MAX_PASSES 28
#define DGB_MAX_TEXTURES 45

/* --- results and log ---------------------------------------------------------------------------------------------- */

typedef enum dgb_result {
    DGB_OK = 0,
    DGB_INVALID,       /* an argument is wrong; nothing changed */
    DGB_UNSUPPORTED,   /* the backend cannot do it; nothing changed */
    DGB_OUT_OF_MEMORY, /* the device has no room; nothing changed, unless while drawing (DGB_LOG_PASS) */
    DGB_DEVICE         /* the device refused for another reason; likewise */
} dgb_result;

/* X(name, sentence): every reason a call can give. */
#define DGB_LOG_ITEMS(X)                                                                                         \
    X(NULL_ARGUMENT, "a required pointer is null")                                                               \
    X(SIZE, "width and height must be 1 to 16384 pixels")                                                        \
    X(GUARD_BAND, "guard_band must be 0 or more, and the image with it no larger than the device allows")        \
    X(LAYERS, "layers must be 1 to 8 (1 or 2 for layers of the engine's own)")                                   \
    X(EFFECTS, "effects holds an unknown bit, or BENT, BOUNCES, GLOSSY or TEMPORAL without what they need")      \
    X(TARGETS, "targets holds an unknown bit or leaves out a target that an effect reads")                       \
    X(ENUM, "an enum of the desc is out of range")                                                               \
    X(PEEL_EMISSION, "the PEEL oracle reads the layer in front of this frame, so it needs SEPARATE emission")    \
    X(DIVISOR, "divisor must be 1, 2 or 4, no more than the smaller side, 1 for IMAGE and MULTICAST")            \
    X(EMISSION, "the backend does not offer this emission")                                                      \
    X(CLIP, "the backend cannot set a clip-space z range of 0 to 1")                                             \
    X(DEEP_VIEWPORT, "the backend cannot give deeper layers a smaller viewport: divisor must be 1")              \
    X(SOURCE_OPTIONS, "layers of the engine's own take no oracle, emission or targets")                          \
    X(BACKEND_VERSION, "the backend was written for another version of deepgbuffer.h")                           \
    X(BACKEND_CALLBACK, "the backend lacks a required callback")                                                 \
    X(TEXTURE, "the backend could not create a texture")                                                         \
    X(PROGRAM, "the backend could not create a program")                                                         \
    X(MATRIX, "view, projection or jitter holds a value that is not finite")                                     \
    X(PROJECTION, "the projection is singular, skewed, oblique, or looks down +Z")                               \
    X(DIRECTION, "depth grows with distance in the projection but desc.reversed is set, or the other way round") \
    X(SEPARATION, "separation must be finite and 0 or more")                                                     \
    X(AO_PARAMS,                                                                                                 \
      "ao_radius must be 1e-15 to 1e14, ao_samples 1 to 256, ao_bias, _epsilon, _intensity finite and >= 0")     \
    X(GATHER_PARAMS, "radius must be 1e-15 to 1e14, samples 1 to 256")                                           \
    X(BITMASK_PARAMS, "slices must be 1 to 8, thickness finite, 0 to 1e14")                                      \
    X(BOUNCE_PARAMS, "bounce_damping must be 0 to 1, boosts finite and >= 0")                                    \
    X(HISTORY_PARAMS,                                                                                            \
      "history_weight must be 0 to 0.999, history_tolerance, _floor, _clamp and sample_clamp finite and >= 0")   \
    X(REFLECT_PARAMS,                                                                                            \
      "reflect_distance and _thickness must be 1e-15 to 1e14, _steps 1 to 4096, _stride 1 to 64, _border >= 0")  \
    X(GLOSSY_PARAMS, "glossy_taps must be 0 to 32, glossy_radius finite and >= 0")                               \
    X(MIP_PARAMS, "minimum MIP levels must be 0 to 5")                                                           \
    X(FILTER_PARAMS, "filter_taps must be odd, 1 to 25, filter_step 1 to 8, sharpness finite and >= 0")          \
    X(GUARD_FRACTION, "guard_fraction must be 0 to 1")                                                           \
    X(WRONG_SOURCE, "dgb_build is for layers the library builds, dgb_set_layers for the engine's own")           \
    X(INPUT, "a texture that the plan reads was not given")                                                      \
    X(NO_LAYERS, "there is nothing to shade: no dgb_build or dgb_set_layers since init, resize or a failure")    \
    X(PASS, "the device failed while it drew: layers or results of this frame are lost")

typedef enum dgb_log_item {
    DGB_LOG_NONE = 0,
#define DGB_LOG_ENUM(name, sentence) DGB_LOG_##name,
    DGB_LOG_ITEMS(DGB_LOG_ENUM)
#undef DGB_LOG_ENUM
        DGB_LOG_COUNT
} dgb_log_item;

/* Called once for each failure, on the calling thread. `sentence` is static text. */
typedef void (*dgb_log_fn)(void* user, dgb_result result, dgb_log_item item, const char* sentence);

/* --- what there is to choose -------------------------------------------------------------------------------------- */

/* Bits of dgb_desc.effects; 0 builds the layers and nothing else. */
enum {
    DGB_EFFECT_AO = 1,        /* ambient occlusion: DGB_AO */
    DGB_EFFECT_RADIOSITY = 2, /* bounced diffuse light: DGB_IRRADIANCE */
    DGB_EFFECT_BOUNCES = 4,   /* with RADIOSITY: one bounce more a frame, and DGB_IRRADIANCE1 for the second layer */
    DGB_EFFECT_TEMPORAL = 8,  /* with AO, RADIOSITY or GLOSSY: averages them over frames */
    DGB_EFFECT_REFLECT = 16,  /* mirror reflections, of bounced light too with RADIOSITY: DGB_REFLECTION */
    DGB_EFFECT_GLOSSY = 32,   /* with REFLECT: by each surface's roughness */
    DGB_EFFECT_BENT = 64      /* with AO and BITMASK: from where the sky is seen: DGB_BENT */
};

/* Bits of dgb_desc.targets: colour targets of a layer, 32 bits a pixel each; 0 means all four. */
enum {
    DGB_TARGET_ALBEDO = 1,   /* RGBA8: linear albedo, one value of the engine's own */
    DGB_TARGET_NORMAL = 2,   /* RGBA8: Oct16 camera-space normal; two of the engine's own, for GLOSSY b: roughness */
    DGB_TARGET_RADIANCE = 4, /* R11G11B10F: outgoing radiance */
    DGB_TARGET_VELOCITY = 8, /* RG16F: motion since the last frame, pixels */
    DGB_TARGET_ALL = 15
};

typedef enum dgb_source {
    DGB_SOURCE_BUILD = 0, /* the library builds the layers: dgb_build */
    DGB_SOURCE_ENGINE     /* the engine has one or two layers already: dgb_set_layers */
} dgb_source;

typedef enum dgb_oracle {
    DGB_ORACLE_DEFAULT = 0, /* REPROJECT */
    DGB_ORACLE_PEEL,        /* paper, Listing 1 */
    DGB_ORACLE_PREVIOUS,    /* paper, section 2.2 */
    DGB_ORACLE_REPROJECT,   /* paper, section 2.2 */
    DGB_ORACLE_PREDICT,     /* paper, section 2.2; a depth-only pass a frame more */
    DGB_ORACLE_DELAY,       /* paper, section 2.2; likewise, and one frame of latency */
    DGB_ORACLE_WARP,        /* a full-screen pass a layer more */
    DGB_ORACLE_COUNT
} dgb_oracle;

typedef enum dgb_emission {
    /* SEPARATE for PEEL or one layer; else caps.preferred, VERTEX, GEOMETRY, SEPARATE: the first there is */
    DGB_EMISSION_AUTO = 0,
    DGB_EMISSION_SEPARATE,           /* one draw callback a layer */
    DGB_EMISSION_GEOMETRY,           /* one draw callback; a geometry shader emits every triangle to every layer */
    DGB_EMISSION_VERTEX,             /* one draw callback; instances times layers, the vertex shader picks the layer */
    DGB_EMISSION_INSTANCED_GEOMETRY, /* one draw callback; one geometry-shader invocation a layer */
    DGB_EMISSION_IMAGE,     /* one draw callback, one rasterisation: deeper layers by compare and store in images */
    DGB_EMISSION_MULTICAST, /* one draw callback; NVIDIA's pass-through geometry shader and viewport multicast */
    DGB_EMISSION_COUNT
} dgb_emission;

typedef enum dgb_clip {
    DGB_CLIP_NEGATIVE_ONE_TO_ONE = 0, /* OpenGL's default clip-space z range */
    DGB_CLIP_ZERO_TO_ONE,
    DGB_CLIP_COUNT
} dgb_clip;

/* How the engine's own normals come (DGB_SOURCE_ENGINE). */
typedef enum dgb_normals {
    DGB_NORMALS_FROM_DEPTH = 0, /* there are none: derive them from depth */
    DGB_NORMALS_OCT16,          /* r, g hold dgb_oct16_encode of the camera-space normal */
    DGB_NORMALS_UNORM,          /* r, g, b hold n * 0.5 + 0.5 */
    DGB_NORMALS_FLOAT,          /* r, g, b hold n */
    DGB_NORMALS_COUNT
} dgb_normals;

/* Which of the two surfaces under a tap send light (paper, section 3.2). */
typedef enum dgb_senders {
    DGB_SENDERS_BOTH = 0,  /* every accepted one: the paper's text. Default: no light is thrown away */
    DGB_SENDERS_STRONGEST, /* the one that sends more, as the authors' demo does */
    DGB_SENDERS_COUNT
} dgb_senders;

/* What divides the gathered sum of M senders. */
typedef enum dgb_normaliser {
    DGB_NORMALISER_BOUNDED = 0, /* E = pi sum(B cos) / max(sum(cos), M/2): at most pi times the brightest sender */
    DGB_NORMALISER_PAPER,       /* E = 2 pi sum(B cos) / M, Equation 4: up to twice that */
    DGB_NORMALISER_COUNT
} dgb_normaliser;

/* What AO and RADIOSITY compute. */
typedef enum dgb_estimator {
    DGB_ESTIMATOR_PAPER = 0, /* the paper's Equations 1 to 5 */
    DGB_ESTIMATOR_BITMASK,   /* shares of the hemisphere that surfaces cover, nearer ones first */
    DGB_ESTIMATOR_COUNT
} dgb_estimator;

/* What ends an object of the first layer sooner than params.thickness and reflect_thickness. */
typedef enum dgb_thickness {
    DGB_THICKNESS_LAYERS = 0, /* the second layer */
    DGB_THICKNESS_CONSTANT,   /* nothing */
    DGB_THICKNESS_BACK_FACES, /* the second layer, and the back face behind it: drawn once more */
    DGB_THICKNESS_COUNT
} dgb_thickness;

/* How the rays of REFLECT are marched; what they hit is the same, bit for bit. */
typedef enum dgb_tracer {
    DGB_TRACER_LINEAR = 0,   /* every step is tested */
    DGB_TRACER_HIERARCHICAL, /* but those that depth ranges rule out: a texture and passes more */
    DGB_TRACER_COUNT
} dgb_tracer;

typedef enum dgb_format {
    DGB_FORMAT_NONE = 0,
    DGB_FORMAT_R8,
    DGB_FORMAT_RG8,
    DGB_FORMAT_RGBA8,
    DGB_FORMAT_R11G11B10F,
    DGB_FORMAT_RG16F,
    DGB_FORMAT_RGBA16F,
    DGB_FORMAT_R32F,
    DGB_FORMAT_RG32F,
    DGB_FORMAT_RGBA32F,
    DGB_FORMAT_R32UI,
    DGB_FORMAT_RG32UI,
    DGB_FORMAT_RGBA32UI,
    DGB_FORMAT_D16,
    DGB_FORMAT_D24,
    DGB_FORMAT_D32F,
    DGB_FORMAT_COUNT
} dgb_format;

/* Every texture there can be. X(enumerator, name): the name is that of the GLSL sampler without its dgb_ prefix. */
#define DGB_SLOTS(X)                                                                                                  \
    /* layers: 2D arrays, one image a layer */                                                                        \
    X(DGB_DEPTH, "depth")                                                                                             \
    X(DGB_ALBEDO, "albedo")                                                                                           \
    X(DGB_NORMAL, "normal")                                                                                           \
    X(DGB_RADIANCE, "radiance")                                                                                       \
    X(DGB_VELOCITY, "velocity")                                                                                       \
    X(DGB_ORACLE, "oracle")       /* the depth layers that the keep test compares with */                             \
    X(DGB_PREDICTED, "predicted") /* depth layers of the next pose (PREDICT, DELAY) */                                \
    X(DGB_KEY, "key")             /* depth bits of deeper layers (IMAGE emission) */                                  \
    X(DGB_BACK, "back")           /* depth of the nearest back faces behind the first layer, a 2D texture */          \
    /* the engine's own layers: 2D textures */                                                                        \
    X(DGB_ENGINE_DEPTH0, "engine_depth0")                                                                             \
    X(DGB_ENGINE_DEPTH1, "engine_depth1")                                                                             \
    X(DGB_ENGINE_NORMAL0, "engine_normal0")                                                                           \
    X(DGB_ENGINE_NORMAL1, "engine_normal1")                                                                           \
    X(DGB_ENGINE_RADIANCE0, "engine_radiance0")                                                                       \
    X(DGB_ENGINE_RADIANCE1, "engine_radiance1")                                                                       \
    X(DGB_ENGINE_ALBEDO0, "engine_albedo0")                                                                           \
    X(DGB_ENGINE_ALBEDO1, "engine_albedo1")                                                                           \
    X(DGB_ENGINE_VELOCITY0, "engine_velocity0")                                                                       \
    X(DGB_ENGINE_VELOCITY1, "engine_velocity1")                                                                       \
    X(DGB_ENGINE_BACK, "engine_back")                                                                                 \
    X(DGB_ENGINE_ROUGHNESS, "engine_roughness")                                                                       \
    /* packed shading input, with MIP levels */                                                                       \
    X(DGB_Z, "z")             /* camera z of both layers, b: of back faces (BACK_FACES); DGB_EMPTY_Z where empty */   \
    X(DGB_NORMALS, "normals") /* Oct16 of both layers */                                                              \
    X(DGB_B0, "b0")           /* radiance of layer 0 */                                                               \
    X(DGB_B1, "b1")           /* radiance of layer 1 */                                                               \
    X(DGB_LAST_Z, "last_z")   /* z of last frame */                                                                   \
    /* tiles of 16 x 16 pixels, regions of 8 x 8 tiles: ranges of depth; whether the second layer matters */          \
    X(DGB_TILE_DEPTHS, "tile_depths")                                                                                 \
    X(DGB_REGION_DEPTHS, "region_depths")                                                                             \
    X(DGB_TILES, "tiles")         /* r: to occlusion, g: to light, b: is there */                                     \
    X(DGB_ROTATIONS, "rotations") /* 256 x 1: cosine and sine of every spiral rotation */                             \
    /* results: raw, averaged over frames, after the horizontal filter, final */                                      \
    X(DGB_AO_RAW, "ao_raw")                                                                                           \
    X(DGB_BENT_RAW, "bent_raw")                                                                                       \
    X(DGB_IRRADIANCE_RAW, "irradiance_raw")                                                                           \
    X(DGB_IRRADIANCE1_RAW, "irradiance1_raw")                                                                         \
    X(DGB_FRAMES, "frames") /* ambient visibility, frames averaged: of it, of layer 0's and layer 1's irradiance */   \
    X(DGB_BENT_MEAN, "bent_mean")                                                                                     \
    X(DGB_IRRADIANCE_MEAN, "irradiance_mean")                                                                         \
    X(DGB_IRRADIANCE1_MEAN, "irradiance1_mean")                                                                       \
    X(DGB_LAST_FRAMES, "last_frames") /* the three of last frame */                                                   \
    X(DGB_LAST_BENT, "last_bent")                                                                                     \
    X(DGB_LAST_IRRADIANCE, "last_irradiance")                                                                         \
    X(DGB_LAST_IRRADIANCE1, "last_irradiance1")                                                                       \
    /* a layer's texel: bits of z; Oct16 below visibility * 65535; irradiance and confidence, 16-bit floats */        \
    X(DGB_HALF, "half")                                                                                               \
    X(DGB_HALF_BENT, "half_bent")                                                                                     \
    X(DGB_HALF1, "half1")                                                                                             \
    X(DGB_AO, "ao")     /* ambient visibility, 1 = open */                                                            \
    X(DGB_BENT, "bent") /* rgb: cosine-weighted mean of the open directions, world space; a: the open share */        \
    X(DGB_IRRADIANCE, "irradiance")   /* rgb: irradiance of layer 0, W/m2; a: confidence, 0 to 1 */                   \
    X(DGB_IRRADIANCE1, "irradiance1") /* of layer 1, unseen: for the next bounce and for mirrors */                   \
    /* depth ranges, with MIP levels: largest and smallest z of layer 0, of layer 1 */                                \
    X(DGB_RANGES, "ranges")                                                                                           \
    X(DGB_REFLECTION_RAW, "reflection_raw")   /* GLOSSY: of one ray; of this frame */                                 \
    X(DGB_LAST_REFLECTION, "last_reflection") /* GLOSSY and TEMPORAL: of last frame, and the frames averaged / 255 */ \
    X(DGB_REFLECTION_FRAMES, "reflection_frames")                                                                     \
    X(DGB_LAST_REFLECTION_FRAMES, "last_reflection_frames")                                                           \
    X(DGB_REFLECTION, "reflection") /* rgb: radiance in the mirror or lobe; a: confidence, 0 where nothing is hit */  \
    /* r: layer hit + 1, 0 for none; g: length of the ray, m; GLOSSY: ba: its direction, camera space, octahedral */  \
    X(DGB_REFLECTION_HIT, "reflection_hit")

typedef enum dgb_slot {
    DGB_SLOT_NONE = 0,
#define DGB_SLOT_ENUM(slot, name) slot,
    DGB_SLOTS(DGB_SLOT_ENUM)
#undef DGB_SLOT_ENUM
        DGB_SLOT_COUNT
} dgb_slot;

typedef enum dgb_pass_id {
    DGB_PASS_WARP = 0, /* oracle WARP: last frame's depth from this frame's camera */
    DGB_PASS_LAYERS,
    DGB_PASS_RESOLVE, /* IMAGE emission: depth bits into the depth layers */
    DGB_PASS_BACK,    /* BACK_FACES: depth of the nearest back faces behind the first layer */
    DGB_PASS_PREDICT, /* PREDICT, DELAY: depth layers of the next pose */
    DGB_PASS_PACK,
    DGB_PASS_MIP,
    DGB_PASS_TILES,
    DGB_PASS_AO,
    DGB_PASS_GATHER,
    DGB_PASS_TEMPORAL,
    DGB_PASS_RECONSTRUCT,
    DGB_PASS_RANGE,
    DGB_PASS_REFLECT,
    DGB_PASS_GLOSSY,
    DGB_PASS_COUNT
} dgb_pass_id;

/* --- handles ------------------------------------------------------------------------------------------------------ */

typedef struct dgb_texture {
    uint64_t id; /* the backend's own; 0 = none */
} dgb_texture;

typedef struct dgb_program {
    uint64_t id; /* the backend's own; 0 = none */
} dgb_program;

/* --- mathematics: pure functions, each with a GLSL twin of the same name in shaders_embedded/00_common.glsl ------- */

/* Octahedral normal in two snorm bytes, stored biased: byte = q + 127, q in -127..127; x is the low byte. Exact on the
   six axes. `n` need not have unit length. Zero, NaN, infinite, or |x|+|y|+|z| outside 1e-30..1e30: +Z.
   Cigolle et al. 2014; the scale 127 instead of 127.5 is what makes the axes exact. */
DGB_API uint16_t dgb_oct16_encode(const float n[3]);
/* Unit vector of a code. Byte 255 reads as 254 (snorm -128 and -127 are one value). */
DGB_API void dgb_oct16_decode(uint16_t code, float n[3]);
/* Both layers' normals in the four bytes of an RGBA8 texel, r lowest: layer 0 in r, g; layer 1 in b, a (Table 1). */
DGB_API uint32_t dgb_pack_normals(const float n0[3], const float n1[3]);
DGB_API void dgb_unpack_normals(uint32_t packed, float n0[3], float n1[3]);

/* What the shaders store: NaN and negative become 0, above 64512 becomes 64512. By selects, never by min or max. */
DGB_API float dgb_storable(float x);
/* R11G11B10F texel of dgb_storable(rgb), rounded to nearest even; r in the low bits. */
DGB_API uint32_t dgb_r11g11b10f_pack(const float rgb[3]);
DGB_API void dgb_r11g11b10f_unpack(uint32_t packed, float rgb[3]);
/* IEEE half. NaN becomes 0; beyond +-65504 becomes +-65504; rounded to nearest even. */
DGB_API uint16_t dgb_half_from_float(float x);
DGB_API float dgb_half_to_float(uint16_t half);
/* One of the two halves around x, within +-65504, on average over u in 0..1 x itself: how an average over frames is
   stored. Stores that always go the same way add up: with a small share of each frame, an average stays where a frame
   moves it less than it rounds. What is a half but for a rounding stays one for every u. */
DGB_API float dgb_dithered(float x, float u);

/* Turns tau of an n-tap spiral: the smallest integer >= 2 (1 for n <= 2) that minimises the discrepancy of the taps in
   the polar unit square (paper, Listing 3, which prints n = 1..98; tests/unit regenerates 1..256 from the measure).
   n > 256: the integer nearest n * (3 - sqrt 5) / 2, the golden section's rotation. n < 1: 0. */
DGB_API int dgb_spiral_turns(int n);
/* Tap i of n: {cos theta, sin theta, kappa}, theta = 2 pi kappa tau, kappa = (i + 0.5) / n (paper, section 3.4).
   i outside 0..n-1 or n < 1: {1, 0, 0}. */
DGB_API void dgb_spiral_tap(int i, int n, float tap[3]);
/* Rotation `index` modulo 256 of a whole turn: {cos, sin}. The table that the shaders read. */
DGB_API void dgb_rotation(int index, float cos_sin[2]);
/* Which of the 256 rotations a pixel takes in a frame: a hash of the pixel, and from frame to frame 159 / 256 of a turn
   more, near the golden section, so that the frames of an average share out the circle. Integers only: the same
   everywhere. */
DGB_API int dgb_pixel_hash(int x, int y, int frame);
/* Two numbers of a pixel and frame for sampling a square, in 0..1, neither 0 nor 1: the R2 sequence (Roberts 2018) over
   the frames from a hash of the pixel. Integers until the last step: the same everywhere. */
DGB_API void dgb_pixel_pair(int x, int y, int frame, float u[2]);
/* Place of a pixel along a Hilbert curve through a square of 64 x 64 pixels, 0..4095, the same in every such square:
   pixels that are near along the curve are near in the image, and most that are near in the image are near along the
   curve. */
DGB_API int dgb_hilbert_index(int x, int y);
/* Four numbers of a pixel and frame, in 0..1, neither 0 nor 1, which neighbours and frames share out among them:
   sequences along the Hilbert curve, 288 places farther from frame to frame. The first two together are the R2 sequence
   (Roberts 2018), the others two of its kin of four dimensions. Integers until the last step: the same everywhere. */
DGB_API void dgb_pixel_quad(int x, int y, int frame, float u[4]);

/* floor(log2(h / 2^log2_q)) clamped to min_level..max_level, from the exponent bits of h (pixels). */
DGB_API int dgb_mip_level(float h, int log2_q, int min_level, int max_level);
/* Number of levels for a width x height image: as many as can be copied without clamping, 1 to DGB_MAX_LEVELS. */
DGB_API int dgb_mip_levels(int width, int height);
/* The level-0 pixel that texel p of `level` was copied from (level m texel p copies 2p + (p.y & 1, p.x & 1) of m-1).
   level below 0: 0; beyond the last: DGB_MAX_LEVELS - 1. */
DGB_API void dgb_mip_source(const int p[2], int level, int source[2]);

/* A projection, reduced to what shaders need. Four vec4 in std140. Fill it with dgb_camera_from_matrix. */
typedef struct dgb_camera {
    float linearise[4];  /* z = (l0 + l1 t) / (l2 + l3 t), t = depth - clear depth: exact where depth is dense */
    float position_z[4]; /* x, y of a point = (pixel * position_z.xy + position_z.zw) * z                         */
    float position_1[4]; /*                 + (pixel * position_1.xy + position_1.zw)   (0 unless orthographic)   */
    float footprint[4];  /* pixels a metre at z = f0 / (f1 z + f2); f3 = the depth that means "empty"             */
} dgb_camera;

/* `projection`: column-major, already widened and jittered; width, height: pixels of the whole buffer.
   DGB_INVALID, and *camera untouched, when the matrix is not finite, is singular, skewed or oblique, looks down +Z, has
   its depth run against `reversed`, or holds numbers so small that what is divided by them overflows. */
DGB_API dgb_result dgb_camera_from_matrix(const float projection[16], int width, int height, dgb_clip clip,
                                          bool reversed, dgb_camera* camera);
/* The projection of the image widened by a guard band and shifted by a jitter (pixels): rows 0 and 1 times
   size / (size + 2 guard), then the jitter. A buffer of less than a pixel counts as one pixel. */
DGB_API void dgb_widen_projection(const float projection[16], int width, int height, int guard_band,
                                  const float jitter[2], float widened[16]);
/* The depth as a fixed-point buffer of `codes` + 1 values holds it (65535 for D16, 16777215 for D24); 0 or less: a
   float buffer, which holds it as it is. Both sides of a comparison go through this, so that equal codes are equal
   numbers. */
DGB_API float dgb_depth_code(float depth, float codes);
/* Camera z, metres, of a depth-buffer value 0..1. The empty depth, NaN, and what lies beyond 1e15 m or not in front of
   the eye (perspective): 0. */
DGB_API float dgb_linear_z(float depth, const dgb_camera* camera);
/* Distance, m, up to which the format (0: D32F) resolves a separation: neighbouring depths are at most that far apart,
   to 0.1 %. Up to half of it, surfaces twice the separation apart are surely in two layers; beyond it, layers are told
   apart where their depths differ, as by plain peeling. Nowhere does a deeper layer come out in front.
   DGB_MAX_DISTANCE: everywhere; 0: nowhere, or the separation is NaN. */
DGB_API float dgb_separation_limit(float separation, dgb_format depth_format, const dgb_camera* camera);
/* Camera-space point at a pixel position (centres at +0.5) and camera z. */
DGB_API void dgb_position(float pixel_x, float pixel_y, float z, const dgb_camera* camera, float point[3]);
/* Pixels that one metre covers at camera z. 0 where z is not in front of the eye. */
DGB_API float dgb_pixels_per_metre(float z, const dgb_camera* camera);

/* Whether a fragment at camera z may enter the layer behind z_front: distance > distance of the front + separation.
   An empty front layer (0) keeps nothing. Paper, Listing 2, line 22. */
DGB_API bool dgb_keep_test(float z, float z_front, float separation);

/* Occlusion by a surface at offset v from a point with unit normal n: max(0, 1 - v.v/r^2) max(0, (v.n - beta) /
   sqrt(v.v + epsilon)). inv_r2 = 1/r^2, 1/m^2; beta m; epsilon m^2. Paper, Equation 2. */
DGB_API float dgb_ao_term(const float v[3], const float n[3], float inv_r2, float beta, float epsilon);
/* Ambient visibility from the sum of the taps' terms: max(0, 1 - sqrt(pi / count * sum)). Paper, Equation 1. */
DGB_API float dgb_ambient_visibility(float sum, int count);
/* Cosine of the light that a surface at offset v with normal n_y sends to a point with normal n_x; 0 when it sends
   none: farther than the radius, behind the receiver or in its plane (DGB_MIN_COSINE: there rounding would decide what
   counts), or (normal_test) facing away. Paper, Equations 4 and 5. */
DGB_API float dgb_gather_term(const float v[3], const float n_x[3], const float n_y[3], float r2, bool normal_test);
/* Irradiance scale: pi / max(sum_cos * k, count / 2), 0 for count = 0; k = 1 bounded, 0 the paper's Equation 4. */
DGB_API float dgb_gather_scale(float sum_cos, int count, float k);
/* Reflectance factor that emphasises colour: lerp(unsaturated, saturated, (max - min) / max). (1, 1) conserves energy,
   (0, 1) is the paper's Equation 7. */
DGB_API float dgb_boost(const float albedo[3], float unsaturated, float saturated);
/* Weight of a neighbour in the reconstruction: normals n, n2, offset dq (m) between the two points.
   max(0, 1 - s_n (1 - n.n2)) max(0, 1 - s_p max(|dq.n|, |dq.n2|) / |dq|)^2; the second factor is 1 for dq = 0. */
DGB_API float dgb_bilateral_weight(const float n[3], const float n2[3], const float dq[3], float normal_sharpness,
                                   float plane_sharpness);

/* The visibility bitmask (Therrien et al. 2023); twins in shaders_embedded/37_sectors.glsl. Directions from a point are
   looked at in slices: half planes that begin at the line of sight and extend `along` a unit vector across it. A
   direction of a slice is its parts towards the eye and along; its angle is 0 towards the eye, pi away from it. */

/* asin(x) by a polynomial (Abramowitz and Stegun 4.4.45): within 6.8e-5. Beyond +-1: that of +-1. NaN: NaN. */
DGB_API float dgb_arc_sine(float x);
/* The slice of the direction n + s: s on the unit sphere, evenly, gives directions of the cosine-weighted hemisphere
   about the unit normal n, and so slices by the light that arrives in them. v: unit, towards the eye. +X where the
   direction is v's own, or not finite. */
DGB_API void dgb_slice_along(const float n[3], const float v[3], const float s[3], float along[3]);
/* What the shares of a slice depend on: cos g, sin g, g, 1 / (cos g + (g + pi/2) sin g), g the angle, -pi/2..pi/2, from
   the eye to the normal's projection on the slice's plane. A normal that faces away from the eye counts as at right
   angles to it. */
DGB_API void dgb_slice(const float n[3], const float v[3], const float along[3], float slice[4]);
/* Share of a slice's cosine-weighted light that arrives between the eye and a direction q {towards the eye, along}, of
   any length: 0 at the eye, 1 at the surface's horizon, below it, on the other side of the line of sight, and where
   something is not finite. Within 4.4e-3, a seventh of a sector, for g from -85 degrees on: narrower slices hold next
   to nothing. */
DGB_API float dgb_slice_share(const float slice[4], const float q[2]);
/* The sectors, of 32 equal shares, from one share to another, both 0..1. u in 0..1, the same for all that are joined or
   compared, rounds the ends: on average over u the number of sectors in any union is exact. from >= to: none. */
DGB_API uint32_t dgb_sectors(float from, float to, float u);
DGB_API int dgb_sector_count(uint32_t sectors);
/* The angle, from the eye on, up to which a slice holds a share 0..1 of its light. Within 1e-3; the horizon for 1. */
DGB_API float dgb_slice_angle(const float slice[4], float share);
/* Sum {towards the eye, along} of a slice's directions from the eye up to an angle, weighted by the cosine of the
   normal so that the weights of all, up to the horizon, add up to 1. */
DGB_API void dgb_slice_sum(const float slice[4], float angle, float sum[2]);
/* The same of the directions in some sectors. Those of all cosine-weighted directions about a normal n, over slices of
   all, have 2/3 n for their mean. */
DGB_API void dgb_sectors_mean(const float slice[4], uint32_t sectors, float sum[2]);
/* Cosine of the half angle of the cone that looks as open as a texel of DGB_BENT: of cosine-weighted directions about
   its axis, the mean is as long. 0 where it is shorter than a hemisphere's, 2/3; 1 for a single direction, and where
   nothing is open. */
DGB_API float dgb_bent_cosine(const float bent[4]);

/* Width alpha of the lobe of a perceptual roughness: its square, at most 1; 0, a mirror, below DGB_MIN_ROUGHNESS and
   for NaN. */
DGB_API float dgb_ggx_alpha(float roughness);
/* One of the microfacets that a viewer sees on a surface with unit normal n: GGX distribution of visible normals of
   width alpha, sampled with u in 0..1 (Heitz 2018, as the spherical cap of Dupuy and Benyoub 2023). v: unit, towards
   the eye. dot(v, h) >= 0 always; h = n for alpha <= 0; where v is behind the surface, or v, n or alpha is not finite,
   h = v or +Z. */
DGB_API void dgb_ggx_normal(const float v[3], const float n[3], float alpha, const float u[2], float h[3]);
/* Density (1/sr) of the unit direction l in which such microfacets mirror v: D(h) G1(v) / (4 n.v), h halfway.
   Integrates to 1 over all directions, those below the surface included. alpha <= 0, not finite, or l = -v: 0. */
DGB_API float dgb_ggx_density(const float v[3], const float n[3], const float l[3], float alpha);

/* --- parameters of a frame ---------------------------------------------------------------------------------------- */

typedef struct dgb_params { /* 0 means 0: start from dgb_preset */
    float separation;       /* minimum separation dz of the layers, m; 0 = classic depth peeling */
    bool strict_separation; /* empty each layer-1 texel within dz of layer 0 when packing */
    float guard_fraction;   /* share of the guard band that is shaded, 0..1; multi-bounce light wants more */

    float ao_radius;    /* m */
    int ao_samples;     /* taps, 1..256 */
    float ao_bias;      /* beta / ao_radius; below 0.017 Oct16 normals darken flat planes */
    float ao_epsilon;   /* epsilon / ao_radius^2 */
    float ao_intensity; /* exponent of the visibility; 1 = the paper's */
    int ao_min_level;   /* coarsest detail allowed near: minimum MIP level, 0..5 */

    float radius;     /* reach of bounced light, m */
    int samples;      /* taps N, 1..256 */
    bool normal_test; /* senders must face the receiver (Equation 5, second half) */
    int min_level;    /* minimum MIP level, 0..5 */

    int slices;      /* BITMASK: planes through the line of sight that share the taps, half to each side; 1..8 */
    float thickness; /* BITMASK: how far behind a surface its object hides at most (desc.thickness), m */

    float bounce_damping;    /* delta: share of last frame's light that is sent on, 0 (one bounce) to 1 */
    float boost_unsaturated; /* factor of that light for grey surfaces, 1: energy is conserved; */
    float boost_saturated;   /* and for fully saturated ones */

    float history_weight;    /* alpha: weight of history in the average, 0 (off) to 0.999 */
    float history_tolerance; /* history must lie within this share of its distance from where the surface was, */
    float history_floor;     /* or within this, m */
    float history_clamp; /* standard deviations of the 3 x 3 pixels' samples that history may be off their mean where a
                            surface moves a pixel a frame or more, farther the less it moves; 0 (off) or more */
    float sample_clamp;  /* times the mean of its neighbours, or its history, that a frame's irradiance counts for at
                            most; 0 (off) or more */

    bool second_alone; /* only second-layer surfaces occlude and send: to look at what they contribute */
    bool adaptive;     /* skip the second layer in tiles where it cannot matter; the results are the same */

    int filter_taps;        /* reconstruction taps in each direction, odd, 1 (off) to 25 */
    int filter_step;        /* pixels from tap to tap, 1..8 */
    float normal_sharpness; /* 0 ignores normals */
    float plane_sharpness;  /* 0 ignores depth */

    float reflect_distance;  /* longest reflected ray, m */
    float reflect_thickness; /* how far behind its surface an object still stops a ray at most (desc.thickness), m */
    int reflect_steps;       /* most steps of a ray, 1..4096 */
    int reflect_stride;      /* pixels a step, 1..64; the hit is then looked for within the step */
    float reflect_border;    /* width of the band at the buffer's border in which confidence fades, pixels */

    int glossy_taps;     /* neighbours whose rays a pixel takes into account, 0 to 32 */
    float glossy_radius; /* no farther away than this, pixels; nearer where the reflection is blurred less */
} dgb_params;

typedef enum dgb_preset_id {
    DGB_PRESET_PERFORMANCE = 0,
    DGB_PRESET_BALANCED,
    DGB_PRESET_QUALITY,
    DGB_PRESET_COUNT
} dgb_preset_id;

/* The paper's Table 2. Out of range: BALANCED. Separation 0.5 m, radii 7.4 m (light) and 1 m (occlusion): set these
   three to your scene; where its unit is not the metre, scale history_floor, thickness, reflect_distance and
   reflect_thickness as well.
                     N    filter taps   normal test   min level   guard band shaded
       PERFORMANCE   13        9            no            3              10 %
       BALANCED      14       11            yes           2              50 %
       QUALITY       30       13            yes           0              80 %                                        */
DGB_API dgb_params dgb_preset(dgb_preset_id id);
/* The estimator to go with a preset, for desc.estimator: which errs least at such a cost, by measurement against ray
   tracing (README, "Which estimator?"). QUALITY: BITMASK; the others, and out of range: PAPER. BITMASK leaves to your
   probe what is open and nothing else: what surfaces in its way make of the probe's light must be in DGB_RADIANCE, or
   rooms without lamps turn out darker than by PAPER. */
DGB_API dgb_estimator dgb_preset_estimator(dgb_preset_id id);
/* What gave the least error for a cost, by measurement: the parameters of BALANCED, with the taps, MIP levels, filter
   and steps of the settings that nothing cheaper beat in the sweep (`make budget`; error against ray tracing, scenes
   averaged). budget: time to shade two layers as a ratio to BALANCED's, on the machine of the sweep, for each of
   `effects` (DGB_EFFECT_*). The table covers about 0.3 to 3: less, or NaN, gives the cheapest, more the most exact.
   With occlusion and light both, the filter is the light's. */
DGB_API dgb_params dgb_preset_for(float budget, uint32_t effects);

/* --- backend ------------------------------------------------------------------------------------------------------ */

typedef struct dgb_caps {
    int max_size;                      /* largest texture side, pixels */
    int max_layers;                    /* largest array texture */
    bool clip_zero_to_one;             /* can set DGB_CLIP_ZERO_TO_ONE */
    bool deep_viewport;                /* can give deeper layers another viewport, of a fractional size */
    dgb_emission preferred;            /* that AUTO takes where the desc allows it; AUTO: no preference */
    bool emission[DGB_EMISSION_COUNT]; /* which emissions work; SEPARATE always must */
} dgb_caps;

typedef struct dgb_texture_desc {
    dgb_slot slot; /* what it is for: a label */
    dgb_format format;
    int width, height;
    int layers; /* 0: a 2D texture; else a 2D array */
    int levels;
    const void* pixels; /* first contents of level 0, tightly packed, or null */
    uint64_t bytes;     /* all levels and layers */
} dgb_texture_desc;

typedef struct dgb_define {
    const char* name;
    int value;
} dgb_define;

typedef struct dgb_program_desc {
    dgb_pass_id pass;
    int define_count;
    dgb_define defines[DGB_MAX_DEFINES];
} dgb_program_desc;

typedef struct dgb_target {
    dgb_texture texture;
    int level;
    int layer; /* -1: all layers at once (layered rendering) */
} dgb_target;

typedef struct dgb_pass {
    dgb_pass_id id;
    int color_count;
    dgb_target colors[DGB_MAX_TARGETS];
    dgb_target depth;              /* texture.id 0: none */
    int x, y;                      /* viewport, pixels of the target */
    float width, height;           /* whole, but for deeper layers of a lower resolution */
    float deep_width, deep_height; /* viewport 1, of layers behind the first in a layered pass; from 0, 0 */
    dgb_emission emission;         /* LAYERS, BACK, PREDICT */
    dgb_texture key;               /* IMAGE emission: 2D array, one image for each of the key_layers behind the first */
    int key_layers;
    bool clear; /* colours to 0, depth to clear_depth */
    float clear_depth;
    bool reversed; /* depth test: nearer is greater */
    dgb_clip clip;
} dgb_pass;

typedef struct dgb_backend {
    int version; /* DGB_VERSION that it was written for */
    void* user;  /* first argument of every callback */
    dgb_caps caps;
    void (*begin)(void* user);     /* optional: save the host's state, set what every pass expects */
    dgb_result (*end)(void* user); /* optional: put it back, and tell what went wrong in the passes */
    dgb_result (*texture_create)(void* user, const dgb_texture_desc* desc, dgb_texture* texture);
    void (*texture_destroy)(void* user, dgb_texture texture);
    dgb_result (*program_create)(void* user, const dgb_program_desc* desc, dgb_program* program);
    void (*program_destroy)(void* user, dgb_program program);
    dgb_result (*pass_begin)(void* user, const dgb_pass* pass);
    /* level >= 0: the pass reads that level only, and sees it as level 0; -1: all levels */
    void (*texture_bind)(void* user, dgb_slot slot, dgb_texture texture, int level);
    void (*uniforms_upload)(void* user, const void* std140, size_t size);
    void (*draw_fullscreen)(void* user, dgb_program program);
    void (*pass_end)(void* user);
    void (*marker)(void* user, dgb_pass_id pass, bool begin); /* optional: around all passes of one id */
} dgb_backend;

/* --- uniforms: std140, one struct a pass -------------------------------------------------------------------------- */

typedef struct dgb_draw_uniforms { /* for the keep test in the engine's shaders */
    dgb_camera camera, previous;   /* previous: of the frame that the oracle holds */
    float distance[4];             /* distance = d0 clip.z + d1 clip.w + d2 */
    float previous_distance[4];
    float size[4];    /* buffer width and height in pixels, separation in m, depth codes (65535, 16777215; 0 float) */
    int32_t layer[4]; /* first layer, layer count, oracle, instance multiplier */
    int32_t flags[4]; /* divisor of this pass's deeper layers, 1 for reversed depth */
} dgb_draw_uniforms;

typedef struct dgb_warp_uniforms {
    dgb_camera camera, last;
    float to_last[3][4]; /* rows: from this frame's camera space to last frame's */
    int32_t layer[4];    /* layer, pixels a texel along one side, last column and row of texels */
    float depth[4];      /* depth codes (65535, 16777215; 0 float) */
} dgb_warp_uniforms;

typedef struct dgb_resolve_uniforms {
    int32_t layer[4]; /* x: image of the key */
} dgb_resolve_uniforms;

typedef struct dgb_reprojection { /* from this frame to last frame */
    dgb_camera last;
    float to_last[3][4]; /* rows: from this frame's camera space to last frame's */
    float tolerance[4];  /* share of the distance, floor (m), 1 if last frame is of use, 0 if nothing has moved since */
    int32_t rect[4];     /* shaded last frame: x0, y0, x1, y1, the last two inclusive */
} dgb_reprojection;

typedef struct dgb_pack_uniforms {
    dgb_camera camera;
    float rotation[3][4]; /* world to camera, columns; identity when normals come in camera space */
    float separation[4];  /* separation (m; -1: not strict), depth codes (0: float) */
    int32_t size[4];      /* buffer width and height */
    float bounce[4];      /* damping, boost of grey, boost of saturated colour, taps */
    dgb_reprojection past;
} dgb_pack_uniforms;

typedef struct dgb_tiles_uniforms {
    dgb_camera camera;
    float radius[4]; /* of occlusion, of light (m); largest reach, 2^least level (pixels) */
} dgb_tiles_uniforms;

typedef struct dgb_ao_uniforms {
    dgb_camera camera;
    int32_t size[4];  /* buffer width and height, taps, frame */
    int32_t level[4]; /* log2 q, min level, max level, 1: no tile may be skipped */
    float radius[4];  /* r (m), 1/r^2, beta (m), epsilon (m^2) */
    float scale[4];   /* pi / N, intensity, largest radius in pixels, 0 to leave out first-layer occluders */
    float taps[DGB_MAX_TAPS][4];
} dgb_ao_uniforms;

typedef struct dgb_gather_uniforms {
    dgb_camera camera;
    int32_t size[4];  /* buffer width and height, taps, frame */
    int32_t level[4]; /* log2 q, min level, max level, 1: no tile may be skipped */
    float radius[4];  /* r (m), r^2, normaliser k, largest radius in pixels */
    float first[4];   /* x: 0 to leave out first-layer senders */
    float taps[DGB_MAX_TAPS][4];
} dgb_gather_uniforms;

typedef struct dgb_bitmask_uniforms { /* BITMASK: of AO and GATHER */
    dgb_camera camera;
    int32_t size[4];   /* buffer width and height, steps to each side of a slice, frame */
    int32_t level[4];  /* log2 q, min level, max level, 1: no tile may be skipped */
    float radius[4];   /* r (m), r^2, thickness (m), largest radius in pixels */
    float scale[4];    /* slices, 1 / slices, exponent of the visibility, 0 to leave out the first layer */
    float world[3][4]; /* camera to world, columns */
} dgb_bitmask_uniforms;

typedef struct dgb_temporal_uniforms {
    dgb_camera camera;
    float weight[4]; /* of history; standard deviations, and times the mean, that are let through; frame */
    int32_t rect[4]; /* shaded rectangle: x0, y0, x1, y1, the last two inclusive */
    dgb_reprojection past;
} dgb_temporal_uniforms;

typedef struct dgb_reconstruct_uniforms {
    dgb_camera camera;
    int32_t rect[4];                             /* shaded rectangle: x0, y0, x1, y1, the last two inclusive */
    int32_t axis[4];                             /* step in x, step in y, taps on one side */
    float sharpness[4];                          /* normal, plane */
    float weights[DGB_MAX_FILTER_RADIUS + 1][4]; /* x: spatial weight at distance i */
} dgb_reconstruct_uniforms;

typedef struct dgb_reflect_uniforms {
    dgb_camera camera;
    int32_t size[4]; /* buffer width and height, most steps, frame */
    int32_t rect[4]; /* shaded rectangle: x0, y0, x1, y1, the last two inclusive */
    float ray[4];    /* longest (m), thickness (m), pixels a step, z of the near plane (m) */
    float fade[4];   /* width of the border (pixels) */
    int32_t skip[4]; /* log2 of the most steps skipped at once, of the least power of two >= pixels a step */
} dgb_reflect_uniforms;

typedef struct dgb_glossy_uniforms {
    dgb_camera camera;
    int32_t rect[4];    /* where there are reflections: x0, y0, x1, y1, the last two inclusive */
    int32_t size[4];    /* taps, frame */
    float reach[4];     /* largest radius (pixels), longest ray (m), weight of history */
    float sharpness[4]; /* normal, plane */
    dgb_reprojection past;
    float taps[DGB_MAX_GLOSSY_TAPS][4];
} dgb_glossy_uniforms;

/* --- plan --------------------------------------------------------------------------------------------------------- */

typedef struct dgb_desc { /* 0 means default */
    int width, height;    /* image, pixels, without guard band */
    int guard_band;       /* pixels on every side; default 0 */
    int layers;           /* default 2 */
    int divisor;          /* resolution of layers behind the first: 1 / divisor; 1, 2 or 4; default 1 */
    uint32_t effects;     /* DGB_EFFECT_*; default none */
    uint32_t targets;     /* DGB_TARGET_*; default all four */
    dgb_source source;
    dgb_oracle oracle; /* default REPROJECT (PEEL for one layer, where there is nothing to choose) */
    dgb_emission emission;
    dgb_format depth_format; /* D16, D24 or D32F; default D32F */
    dgb_clip clip;
    bool reversed;       /* nearer is greater */
    dgb_normals normals; /* DGB_SOURCE_ENGINE */
    bool world_normals;  /* DGB_SOURCE_ENGINE: normals are in world space */
    dgb_senders senders;
    dgb_normaliser normaliser;
    dgb_tracer tracer;
    dgb_estimator estimator;
    dgb_thickness thickness;
    const dgb_backend* backend; /* null: dgb_make_plan assumes a device that can do everything */
    dgb_log_fn log;             /* may be null */
    void* log_user;
} dgb_desc;

typedef struct dgb_plan_input {
    dgb_slot name;    /* what the program calls it */
    dgb_slot texture; /* what is bound there */
} dgb_plan_input;

typedef struct dgb_plan_pass {
    dgb_pass_id id;
    int level;   /* MIP, RANGE: level written. TILES: step. RECONSTRUCT: 0 along x, 1 along y */
    int program; /* index into programs; -1 where your draw callback draws: LAYERS, BACK, PREDICT */
    int input_count, output_count;
    dgb_plan_input inputs[DGB_MAX_INPUTS];
    dgb_slot outputs[DGB_MAX_TARGETS];
} dgb_plan_pass;

typedef struct dgb_plan {
    int width, height; /* of the buffers: image plus guard band */
    int layers, levels;
    dgb_oracle oracle;     /* as resolved */
    dgb_emission emission; /* as resolved */
    int texture_count, program_count, pass_count;
    dgb_texture_desc textures[DGB_MAX_TEXTURES];
    dgb_program_desc programs[DGB_MAX_PROGRAMS];
    dgb_plan_pass passes[DGB_MAX_PASSES];
    uint64_t bytes; /* of all textures */
} dgb_plan;

/* What dgb_init would create and run: every texture, program and pass, with bytes. Pure: needs no device. Logs and
   returns DGB_INVALID or DGB_UNSUPPORTED, *plan untouched, for a desc that dgb_init would refuse. */
DGB_API dgb_result dgb_make_plan(const dgb_desc* desc, dgb_plan* plan);

/* --- context and frame -------------------------------------------------------------------------------------------- */

typedef struct dgb_view {
    float view[16];       /* world to camera */
    float projection[16]; /* of the image: no guard band, no jitter */
    float jitter[2];      /* pixels; added to the widened projection */
    bool cut;             /* the camera jumped: last frame is of no use */
    bool has_next;        /* next_view is known; else PREDICT goes on moving as from the last frame to this */
    float next_view[16];  /* of the next frame, for PREDICT */
} dgb_view;

typedef struct dgb_draw {         /* what the engine's draw callback is told */
    int first_layer, layer_count; /* 0, k in a single pass; j, 1 for separate draws */
    int instances;                /* multiply your instance count, and attribute divisors, by this */
    dgb_oracle oracle;            /* of this pass: PEEL on first frames */
    dgb_emission emission;
    int pose;                       /* draw objects as they are in the frame of the view (0), before it (-1: DELAY),
                                       or after it (1: PREDICT); `previous` is the pose before that */
    bool depth_only;                /* no colour is kept: a cheaper program will do */
    bool back_faces;                /* cull front faces instead of back faces; what has two sides, neither */
    int width, height;              /* buffer, guard band included */
    float view[16], projection[16]; /* projection: widened and jittered; draw with it */
    float previous_view[16], previous_projection[16];
} dgb_draw;

/* Draws every opaque object once, with programs that contain the snippets. The layered target is bound, its viewport
   set, colour and depth writes on, the depth test set. May change any device state, but draws into the bound target. */
typedef void (*dgb_draw_fn)(void* user, const dgb_draw* draw);

typedef struct dgb_layers { /* the engine's own layers (DGB_SOURCE_ENGINE): 2D textures of the plan's buffer size */
    dgb_texture depth[DGB_MAX_SHADED_LAYERS];    /* depth-buffer values in the desc's convention */
    dgb_texture normal[DGB_MAX_SHADED_LAYERS];   /* as desc.normals says; unread for DGB_NORMALS_FROM_DEPTH */
    dgb_texture radiance[DGB_MAX_SHADED_LAYERS]; /* outgoing radiance; read for radiosity only */
    dgb_texture albedo[DGB_MAX_SHADED_LAYERS];   /* linear; read for more than one bounce and for mirrored light only */
    dgb_texture velocity[DGB_MAX_SHADED_LAYERS]; /* r, g: pixels moved since last frame, jitter included; b, if there is
                                                    one: metres of camera z by which the object itself moved. Read for
                                                    more than one bounce and for the temporal filter only */
    dgb_texture back;      /* depth of the nearest back faces behind the first layer; read for BACK_FACES only */
    dgb_texture roughness; /* r: perceptual roughness of the first layer, 0 to 1; read for GLOSSY only */
} dgb_layers;

typedef struct dgb_pose { /* a camera as drawn with: the projection widened and jittered */
    float view[16], projection[16];
} dgb_pose;

typedef struct dgb_context { /* yours to place; its members are the library's */
    uint32_t initialised;
    dgb_desc desc;
    dgb_backend backend;
    dgb_plan plan;
    dgb_texture textures[DGB_SLOT_COUNT];
    dgb_program programs[DGB_MAX_PROGRAMS];
    bool has_layers;          /* something to shade */
    bool has_previous;        /* the oracle holds a frame */
    bool has_history;         /* what dgb_shade left is of the same place */
    uint32_t built, shaded;   /* number of the layers there are, and of those that were shaded last */
    uint32_t frame;           /* calls of dgb_shade */
    dgb_params shaded_params; /* of the last dgb_shade */
    dgb_pose shaded_pose;
    dgb_camera shaded_camera;
    dgb_pose drawn;           /* last */
    dgb_pose pending;         /* DELAY: submitted, not drawn yet */
    dgb_camera camera;        /* of `drawn` */
    dgb_camera oracle_camera; /* that the depth for the next frame's keep test was drawn with */
    dgb_result drawing;       /* what became of the passes of this call */
} dgb_context;

/* Creates every texture and program of the plan. All or nothing: on failure *context is as before. Do not call it on a
   live context. DGB_INVALID, DGB_UNSUPPORTED, DGB_OUT_OF_MEMORY, DGB_DEVICE. */
DGB_API dgb_result dgb_init(dgb_context* context, const dgb_desc* desc);
/* Recreates the textures for another image size. All or nothing: on failure the old ones go on. The next frame is built
   by peeling. The same size does nothing. */
DGB_API dgb_result dgb_resize(dgb_context* context, int width, int height);
/* Destroys all objects. A context that is null, zero or already shut down is ignored. */
DGB_API void dgb_shutdown(dgb_context* context);

/* Builds the layers: calls `draw` once (single pass) or once a layer, and again for the depth that PREDICT, DELAY and
   BACK_FACES want; dgb_draw says what each call is for. All of params is checked, separation alone is used.
   DGB_INVALID, and nothing is drawn: null, a wrong matrix or parameter, a context for the engine's own layers (the log
   says which). DGB_OUT_OF_MEMORY, DGB_DEVICE: the device failed, the layers are lost. */
DGB_API dgb_result dgb_build(dgb_context* context, const dgb_view* view, const dgb_params* params, dgb_draw_fn draw,
                             void* user);
/* Instead of dgb_build: takes the engine's own layers for every dgb_shade until the next call. The textures must live
   as long; they are read, never written. DGB_INVALID, and nothing is taken: null, a wrong matrix, a missing texture
   that the plan reads, a context that builds its own. */
DGB_API dgb_result dgb_set_layers(dgb_context* context, const dgb_view* view, const dgb_layers* layers);
/* Runs every pass after LAYERS. Radiance must have been written by now if radiosity is on. Another call without new
   layers is another frame in which nothing has moved. Two dgb_build without a call between them lose the history, whose
   velocities reach back one frame. DGB_INVALID, and nothing runs: null, a wrong parameter, no layers.
   DGB_OUT_OF_MEMORY, DGB_DEVICE: the device failed, history and results are lost. */
DGB_API dgb_result dgb_shade(dgb_context* context, const dgb_params* params);

/* A texture of the plan, id 0 if the plan has none, for a null or dead context, or a slot out of range. Valid until
   dgb_resize, dgb_shutdown, or, for those that change places with last frame's, the next dgb_build (DGB_DEPTH,
   DGB_ORACLE, DGB_PREDICTED) or dgb_shade (DGB_Z, DGB_FRAMES, the means, with GLOSSY and TEMPORAL DGB_REFLECTION, and
   all DGB_LAST). DGB_AO and DGB_IRRADIANCE stay. */
DGB_API dgb_texture dgb_get_texture(const dgb_context* context, dgb_slot slot);

DGB_API const char* dgb_result_name(dgb_result result);       /* "DGB_OK"; "?" out of range, here and below */
DGB_API const char* dgb_log_item_name(dgb_log_item item);     /* "SIZE" */
DGB_API const char* dgb_slot_name(dgb_slot slot);             /* "ao_raw" */
DGB_API const char* dgb_pass_name(dgb_pass_id pass);          /* "gather" */
DGB_API const char* dgb_format_name(dgb_format format);       /* "RG32F" */
DGB_API const char* dgb_oracle_name(dgb_oracle oracle);       /* "reproject" */
DGB_API const char* dgb_emission_name(dgb_emission emission); /* "vertex" */

#ifdef __cplusplus
}
#endif

#endif /* DEEPGBUFFER_H */

#if defined(DEEPGBUFFER_IMPLEMENTATION) && !defined(DEEPGBUFFER_IMPLEMENTED)
#define DEEPGBUFFER_IMPLEMENTED

#include <math.h>
#include <string.h>

#ifndef DGB_ASSERT
#include <assert.h>
#define DGB_ASSERT(c) assert(c)
#endif

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function" /* DGB_API static: an engine need not call everything */
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* >> numbers: every test of a float is a test of its bits, so that -ffast-math cannot remove it */

#define DGBI_PI 3.14159265358979323846
#define DGBI_COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

static uint32_t dgbi_bits(float x) {
    uint32_t u;
    memcpy(&u, &x, sizeof u);
    return u;
}

static float dgbi_from_bits(uint32_t u) {
    float x;
    memcpy(&x, &u, sizeof x);
    return x;
}

static bool dgbi_is_nan(float x) { return (dgbi_bits(x) & 0x7fffffffu) > 0x7f800000u; }

static bool dgbi_is_finite(float x) { return (dgbi_bits(x) & 0x7f800000u) != 0x7f800000u; }

static bool dgbi_all_finite(const float* x, int count) {
    int i;
    for (i = 0; i < count; ++i)
        if (!dgbi_is_finite(x[i])) return false;
    return true;
}

static bool dgbi_same_bits(const float* a, const float* b, int count) {
    int i;
    for (i = 0; i < count; ++i)
        if (dgbi_bits(a[i]) != dgbi_bits(b[i])) return false;
    return true;
}

static int dgbi_clamp(int x, int low, int high) { return x < low ? low : x > high ? high : x; }

static int dgbi_min(int a, int b) { return a < b ? a : b; }

static float dgbi_max0(float x) { return x > 0.0f ? x : 0.0f; }

static float dgbi_dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* >> packing: normals, radiance */

static float dgbi_sign(float x) { return x < 0.0f ? -1.0f : 1.0f; }

static uint32_t dgbi_snorm_byte(float x) { return (uint32_t)((int)floorf(x * 127.0f + 0.5f) + 127); }

static float dgbi_snorm_value(uint32_t byte) { return (float)((int)(byte < 254u ? byte : 254u) - 127) / 127.0f; }

DGB_API uint16_t dgb_oct16_encode(const float n[3]) {
    const float s = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    float x = 0.0f, y = 0.0f;
    if (dgbi_is_finite(s) && s > 1e-30f && s < 1e30f) {
        x = n[0] / s;
        y = n[1] / s;
        if (n[2] < 0.0f) {
            const float folded_x = (1.0f - fabsf(y)) * dgbi_sign(x);
            y = (1.0f - fabsf(x)) * dgbi_sign(y);
            x = folded_x;
        }
    }
    return (uint16_t)(dgbi_snorm_byte(x) | dgbi_snorm_byte(y) << 8);
}

DGB_API void dgb_oct16_decode(uint16_t code, float n[3]) {
    const float x = dgbi_snorm_value(code & 255u), y = dgbi_snorm_value((uint32_t)code >> 8);
    const float z = 1.0f - fabsf(x) - fabsf(y);
    const float unfold_x = z < 0.0f ? (1.0f - fabsf(y)) * dgbi_sign(x) : x;
    const float unfold_y = z < 0.0f ? (1.0f - fabsf(x)) * dgbi_sign(y) : y;
    const float length = sqrtf(unfold_x * unfold_x + unfold_y * unfold_y + z * z);
    n[0] = unfold_x / length;
    n[1] = unfold_y / length;
    n[2] = z / length;
}

DGB_API uint32_t dgb_pack_normals(const float n0[3], const float n1[3]) {
    return (uint32_t)dgb_oct16_encode(n0) | (uint32_t)dgb_oct16_encode(n1) << 16;
}

DGB_API void dgb_unpack_normals(uint32_t packed, float n0[3], float n1[3]) {
    dgb_oct16_decode((uint16_t)(packed & 0xffffu), n0);
    dgb_oct16_decode((uint16_t)(packed >> 16), n1);
}

DGB_API float dgb_storable(float x) {
    if (dgbi_is_nan(x) || dgbi_bits(x) >> 31) return 0.0f;
    return x < DGB_MAX_RADIANCE ? x : DGB_MAX_RADIANCE;
}

/* Unsigned float with a 5-bit exponent (bias 15) and `mantissa` bits, of a finite x >= 0, rounded to nearest even. */
static uint32_t dgbi_small_float_pack(float x, int mantissa) {
    const uint32_t bits = dgbi_bits(x);
    const int shift = 23 - mantissa;
    int drop;
    uint32_t value, half, rest;
    if (bits >= 0x38800000u) { /* 2^-14 and more: normal. Rebias the exponent, then round off the low bits */
        value = bits - 0x38000000u;
        drop = shift;
    } else { /* subnormal: the implicit one becomes explicit and moves down */
        drop = shift + 113 - (int)(bits >> 23);
        if (drop > 24 + 1) return 0u;
        value = (bits & 0x7fffffu) | 0x800000u;
    }
    half = 1u << (drop - 1);
    rest = value & ((half << 1) - 1u);
    value >>= drop;
    return value + (rest > half || (rest == half && (value & 1u)) ? 1u : 0u);
}

static float dgbi_small_float_unpack(uint32_t code, int mantissa) {
    const uint32_t exponent = code >> mantissa, fraction = code & ((1u << mantissa) - 1u);
    if (exponent == 31u) return dgbi_from_bits(0x7f800000u | fraction << (23 - mantissa));
    if (exponent == 0u) return (float)fraction / (float)(1u << (14 + mantissa));
    return dgbi_from_bits((exponent + 112u) << 23 | fraction << (23 - mantissa));
}

DGB_API uint32_t dgb_r11g11b10f_pack(const float rgb[3]) {
    return dgbi_small_float_pack(dgb_storable(rgb[0]), 6) | dgbi_small_float_pack(dgb_storable(rgb[1]), 6) << 11 |
           dgbi_small_float_pack(dgb_storable(rgb[2]), 5) << 22;
}

DGB_API void dgb_r11g11b10f_unpack(uint32_t packed, float rgb[3]) {
    rgb[0] = dgbi_small_float_unpack(packed & 2047u, 6);
    rgb[1] = dgbi_small_float_unpack(packed >> 11 & 2047u, 6);
    rgb[2] = dgbi_small_float_unpack(packed >> 22, 5);
}

DGB_API uint16_t dgb_half_from_float(float x) {
    const uint32_t sign = dgbi_bits(x) >> 31 << 15;
    const float size = dgbi_from_bits(dgbi_bits(x) & 0x7fffffffu);
    if (dgbi_is_nan(x)) return 0u;
    return (uint16_t)(sign | dgbi_small_float_pack(size < 65504.0f ? size : 65504.0f, 10));
}

DGB_API float dgb_half_to_float(uint16_t half) {
    const float size = dgbi_small_float_unpack(half & 0x7fffu, 10);
    return half >> 15 ? -size : size;
}

DGB_API float dgb_dithered(float x, float u) {
    const float share = dgbi_is_finite(u) && u > 0.0f ? (u < 1.0f ? u : 1.0f) : 0.0f;
    const uint32_t below = 2u + (uint32_t)(share * 8188.0f); /* of the 8192 floats from a half to the next */
    if (!dgbi_is_finite(x)) return x;
    if ((dgbi_bits(x) & 0x7fffffffu) >= 0x38800000u) return dgbi_from_bits((dgbi_bits(x) + below) & 0xffffe000u);
    return floorf(x * 16777216.0f + (float)below / 8192.0f) / 16777216.0f; /* below 2^-14 halves are 2^-24 apart */
}

/* >> taps: spiral, rotation, MIP level */

/* Minimisers of the discrepancy for n = 1..256; the first 98 are the paper's Listing 3. */
static const uint8_t dgbi_spiral_turns[DGB_MAX_TAPS] = {
    1,  1,  2,  3,  2,  5,  2,  3,  2,  3,  3,  5,  5,  3,  4,  7,  5,  5,  7,  9,  8,  5,  5,   7,  7,  7,  8,  5,  8,
    11, 12, 7,  10, 13, 8,  11, 8,  7,  14, 11, 11, 13, 12, 13, 19, 17, 13, 11, 18, 19, 11, 11,  14, 17, 21, 15, 16, 17,
    18, 13, 17, 11, 17, 19, 18, 25, 18, 19, 19, 29, 21, 19, 27, 31, 29, 21, 18, 17, 29, 31, 31,  23, 18, 25, 26, 25, 23,
    19, 34, 19, 27, 21, 25, 39, 29, 17, 21, 27, 29, 27, 30, 19, 37, 29, 29, 31, 41, 29, 30, 23,  31, 31, 21, 25, 34, 45,
    43, 21, 50, 43, 46, 33, 34, 29, 27, 19, 29, 47, 49, 51, 50, 35, 51, 29, 41, 31, 37, 37, 41,  37, 43, 31, 31, 55, 44,
    41, 41, 41, 40, 59, 59, 59, 55, 43, 57, 29, 34, 57, 44, 43, 45, 43, 44, 45, 49, 49, 46, 71,  64, 47, 50, 63, 66, 31,
    47, 65, 49, 49, 50, 41, 50, 41, 67, 51, 68, 55, 71, 69, 40, 41, 74, 71, 81, 75, 59, 75, 43,  53, 55, 59, 56, 59, 44,
    55, 61, 47, 76, 79, 80, 59, 59, 81, 59, 49, 64, 61, 47, 59, 67, 93, 50, 47, 66, 47, 62, 61,  61, 41, 64, 83, 50, 51,
    89, 71, 66, 65, 64, 87, 66, 71, 55, 65, 92, 51, 93, 73, 68, 91, 76, 67, 98, 55, 68, 55, 107, 75};

DGB_API int dgb_spiral_turns(int n) {
    if (n < 1) return 0;
    if (n <= DGB_MAX_TAPS) return dgbi_spiral_turns[n - 1];
    return (int)((double)n * 0.38196601125010515 + 0.5);
}

DGB_API void dgb_spiral_tap(int i, int n, float tap[3]) {
    const bool valid = n >= 1 && i >= 0 && i < n;
    const double kappa = valid ? ((double)i + 0.5) / (double)n : 0.0;
    /* only the fraction of a turn matters; taking it in integers keeps it exact */
    const int64_t half_turns = valid ? (2 * (int64_t)i + 1) * dgb_spiral_turns(n) % (2 * (int64_t)n) : 0;
    const double theta = valid ? DGBI_PI * (double)half_turns / (double)n : 0.0;
    tap[0] = (float)cos(theta);
    tap[1] = (float)sin(theta);
    tap[2] = (float)kappa;
}

DGB_API void dgb_rotation(int index, float cos_sin[2]) {
    const double phi = 2.0 * DGBI_PI * (double)(index & (DGB_ROTATION_COUNT - 1)) / DGB_ROTATION_COUNT;
    cos_sin[0] = (float)cos(phi);
    cos_sin[1] = (float)sin(phi);
}

DGB_API int dgb_pixel_hash(int x, int y, int frame) {
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    return (int)(((h >> 24) + (uint32_t)frame * 159u) & 255u);
}

DGB_API void dgb_pixel_pair(int x, int y, int frame, float u[2]) {
    uint32_t h = (uint32_t)x * 0x8da6b343u ^ (uint32_t)y * 0xd8163841u, g;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    g = (h ^ h >> 16) * 0x2c1b3c6du;
    g = (g ^ g >> 15) * 0x297a2d39u;
    /* 2^32 / p and 2^32 / p^2, p^3 = p + 1; 23 bits and a half are a float */
    u[0] = ((float)((h + (uint32_t)frame * 3242174889u) >> 9) + 0.5f) / 8388608.0f;
    u[1] = ((float)((g + (uint32_t)frame * 2447445414u) >> 9) + 0.5f) / 8388608.0f;
}

/* From the largest quarter to the smallest: which one the pixel is in, 0 to 3 along the curve, two bits of the index
   each; the curve through the first and the last quarter is turned. */
DGB_API int dgb_hilbert_index(int x, int y) {
    uint32_t a = (uint32_t)x, b = (uint32_t)y, index = 0u;
    int bit;
    for (bit = 5; bit >= 0; --bit) {
        const uint32_t right = a >> bit & 1u, upper = b >> bit & 1u, turned = right ? 0xffffffffu : 0u, c = a;
        index = index << 2 | ((3u * right) ^ upper);
        if (upper) continue;
        a = b ^ turned;
        b = c ^ turned;
    }
    return (int)index;
}

DGB_API void dgb_pixel_quad(int x, int y, int frame, float u[4]) {
    /* 2^32 / p and 2^32 / p^2, p^3 = p + 1; 2^32 / q^3 and 2^32 / q^4, q^5 = q + 1 */
    static const uint32_t steps[4] = {3242174889u, 2447445414u, 2700274806u, 2313257605u};
    const uint32_t place = (uint32_t)dgb_hilbert_index(x, y) + (uint32_t)frame * 288u + 1u;
    int i;
    for (i = 0; i < 4; ++i) u[i] = ((float)(place * steps[i] >> 9) + 0.5f) / 8388608.0f;
}

DGB_API int dgb_mip_level(float h, int log2_q, int min_level, int max_level) {
    if (dgbi_is_nan(h) || dgbi_bits(h) >> 31) return min_level;
    return dgbi_clamp((int)(dgbi_bits(h) >> 23) - 127 - dgbi_clamp(log2_q, -256, 256), min_level, max_level);
}

DGB_API int dgb_mip_levels(int width, int height) {
    int levels = 1;
    while (levels < DGB_MAX_LEVELS && width >> levels > 0 && height >> levels > 0) ++levels;
    return levels;
}

DGB_API void dgb_mip_source(const int p[2], int level, int source[2]) {
    const uint32_t m = (uint32_t)dgbi_clamp(level, 0, DGB_MAX_LEVELS - 1);
    /* sums of every other power of two below 2^m */
    const uint32_t even = 0xaaaau >> (16u - m), odd = 0x5555u >> (16u - m), x = (uint32_t)p[0], y = (uint32_t)p[1];
    source[0] = (int)((x << m) + (y & 1u) * even + (x & 1u) * odd);
    source[1] = (int)((y << m) + (x & 1u) * even + (y & 1u) * odd);
}

/* >> camera: depth, position */

static float dgbi_clear_depth(bool reversed) { return reversed ? 0.0f : 1.0f; }

/* What the rest of this section can invert: x and y scaled and shifted, z and w functions of z alone. */
static bool dgbi_projection_ok(const float p[16]) {
    const bool perspective = p[11] < 0.0f && p[15] == 0.0f, orthographic = p[11] == 0.0f && p[15] > 0.0f;
    if (!dgbi_all_finite(p, 16) || !(perspective || orthographic)) return false;
    if (p[1] != 0.0f || p[2] != 0.0f || p[3] != 0.0f || p[4] != 0.0f || p[6] != 0.0f || p[7] != 0.0f) return false;
    return p[0] != 0.0f && p[5] != 0.0f && (perspective ? p[14] : p[10]) != 0.0f;
}

/* The sign of d depth / d distance: that of the determinant of rows 2 and 3 for perspective, of -row 2 otherwise. */
static bool dgbi_depth_grows(const float p[16]) { return p[11] < 0.0f ? p[14] < 0.0f : p[10] < 0.0f; }

static dgb_log_item dgbi_check_projection(const float p[16], bool reversed) {
    if (!dgbi_all_finite(p, 16)) return DGB_LOG_MATRIX;
    if (!dgbi_projection_ok(p)) return DGB_LOG_PROJECTION;
    return dgbi_depth_grows(p) == reversed ? DGB_LOG_DIRECTION : DGB_LOG_NONE;
}

/* ndc = scale * pixel - 1, and x = (ndc w - p_z z - p_1) / p_x with w = w_z z + w_1: collected by powers of pixel
   and z. */
static void dgbi_unproject_axis(const float p[16], int axis, int size, dgb_camera* camera) {
    const double scale = 2.0 / size, p_x = p[axis * 5], p_z = p[8 + axis], p_1 = p[12 + axis], w_z = p[11], w_1 = p[15];
    camera->position_z[axis] = (float)(scale * w_z / p_x);
    camera->position_z[2 + axis] = (float)((-w_z - p_z) / p_x);
    camera->position_1[axis] = (float)(scale * w_1 / p_x);
    camera->position_1[2 + axis] = (float)((-w_1 - p_1) / p_x);
}

/* distance = d0 clip.z + d1 clip.w + d2, from whichever of the two carries z */
static void dgbi_distance_row(const float p[16], float row[4]) {
    const bool perspective = p[11] != 0.0f;
    row[0] = perspective ? 0.0f : -1.0f / p[10];
    row[1] = perspective ? -1.0f / p[11] : 0.0f;
    row[2] = perspective ? p[15] / p[11] : p[14] / p[10];
    row[3] = 0.0f;
}

DGB_API dgb_result dgb_camera_from_matrix(const float projection[16], int width, int height, dgb_clip clip,
                                          bool reversed, dgb_camera* camera) {
    const float* p = projection;
    dgb_camera result;
    float distance[4];
    /* ndc z = a depth + b, depth = t + clear depth: ndc = a t + c */
    const double a = clip == DGB_CLIP_ZERO_TO_ONE ? 1.0 : 2.0;
    const double c = a * (double)dgbi_clear_depth(reversed) + (clip == DGB_CLIP_ZERO_TO_ONE ? 0.0 : -1.0);
    if (dgbi_check_projection(p, reversed) != DGB_LOG_NONE || width < 1 || height < 1) return DGB_INVALID;
    memset(&result, 0, sizeof result);
    /* ndc (w_z z + w_1) = p_z z + p_1, solved for z */
    result.linearise[0] = (float)((double)p[14] - c * (double)p[15]);
    result.linearise[1] = (float)(-a * (double)p[15]);
    result.linearise[2] = (float)(c * (double)p[11] - (double)p[10]);
    result.linearise[3] = (float)(a * (double)p[11]);
    dgbi_unproject_axis(p, 0, width, &result);
    dgbi_unproject_axis(p, 1, height, &result);
    result.footprint[0] = 0.5f * fabsf(p[5]) * (float)height;
    result.footprint[1] = p[11];
    result.footprint[2] = p[15];
    result.footprint[3] = dgbi_clear_depth(reversed);
    dgbi_distance_row(p, distance);
    if (!dgbi_all_finite(result.linearise, 4) || !dgbi_all_finite(result.position_z, 4) ||
        !dgbi_all_finite(result.position_1, 4) || !dgbi_is_finite(result.footprint[0]) || !dgbi_all_finite(distance, 3))
        return DGB_INVALID; /* the inverse overflows */
    *camera = result;
    return DGB_OK;
}

static double dgbi_buffer_size(int size, int guard_band) {
    const double pixels = size + 2.0 * guard_band;
    return pixels > 1.0 ? pixels : 1.0;
}

DGB_API void dgb_widen_projection(const float projection[16], int width, int height, int guard_band,
                                  const float jitter[2], float widened[16]) {
    const double size[2] = {dgbi_buffer_size(width, guard_band), dgbi_buffer_size(height, guard_band)};
    const double scale[2] = {width / size[0], height / size[1]};
    int row, column;
    for (column = 0; column < 4; ++column) {
        const double w = projection[column * 4 + 3];
        for (row = 0; row < 2; ++row)
            widened[column * 4 + row] =
                (float)((double)projection[column * 4 + row] * scale[row] + 2.0 * (double)jitter[row] / size[row] * w);
        widened[column * 4 + 2] = projection[column * 4 + 2];
        widened[column * 4 + 3] = projection[column * 4 + 3];
    }
}

DGB_API float dgb_depth_code(float depth, float codes) {
    const float scaled = depth * codes;
    if (!(codes > 0.0f) || !(scaled >= 0.0f && scaled <= codes)) return depth;
    return (scaled < 8388608.0f ? floorf(scaled + 0.5f) : scaled) / codes; /* from 2^23 on floats are integers */
}

DGB_API float dgb_linear_z(float depth, const dgb_camera* camera) {
    const float* l = camera->linearise;
    const float t = depth - camera->footprint[3];
    const float w = l[2] + l[3] * t;
    const float z = w != 0.0f ? (l[0] + l[1] * t) / w : 0.0f;
    const bool perspective = camera->footprint[1] != 0.0f;
    if (!dgbi_is_finite(depth) || !dgbi_is_finite(z) || t == 0.0f || fabsf(z) > DGB_MAX_DISTANCE ||
        (perspective && z >= 0.0f))
        return 0.0f;
    return z;
}

static float dgbi_depth_codes(dgb_format format) {
    return format == DGB_FORMAT_D16 ? 65535.0f : format == DGB_FORMAT_D24 ? 16777215.0f : 0.0f;
}

/* From a float to the next: twice 2^-24, for mantissas of 1/2 to 1. */
static double dgbi_float_step(double x) {
    int exponent;
    (void)frexp(x, &exponent);
    return ldexp(1.0, exponent - 24);
}

#define DGBI_BEYOND_FAR 1e300

/* Metres from one depth, and from one float z, to the next, whichever is more; 0 before the near plane. */
static double dgbi_resolution(double distance, float codes, const dgb_camera* camera) {
    const double l0 = (double)camera->linearise[0], l1 = (double)camera->linearise[1];
    const double l2 = (double)camera->linearise[2], l3 = (double)camera->linearise[3];
    const double clear = (double)camera->footprint[3];
    const double below = l3 * distance + l1, t = below != 0.0 ? -(l0 + l2 * distance) / below : 0.0, depth = t + clear;
    const double w = l2 + l3 * t, slope = w != 0.0 ? fabs(l1 * l2 - l0 * l3) / w / w : 0.0;
    const double z_step = dgbi_float_step(distance);
    const double step = slope * (codes > 0.0f ? 1.0 / (double)codes : dgbi_float_step(depth));
    if (!(depth >= 0.0 && depth <= 1.0)) return (clear > 0.5 ? depth > 1.0 : depth < 0.0) ? DGBI_BEYOND_FAR : 0.0;
    return step > z_step ? step : z_step;
}

DGB_API float dgb_separation_limit(float separation, dgb_format depth_format, const dgb_camera* camera) {
    const float codes = dgbi_depth_codes(depth_format);
    const double finer = 1.0009765625;
    double distance = 1e-15;
    if (dgbi_is_nan(separation)) return 0.0f;
    /* the resolution grows with the distance, but where floats become finer drops by half at most */
    while (distance < (double)DGB_MAX_DISTANCE && dgbi_resolution(distance, codes, camera) <= (double)separation)
        distance *= 2.0 * dgbi_resolution(2.0 * distance, codes, camera) <= (double)separation ? 2.0 : finer;
    if (distance >= (double)DGB_MAX_DISTANCE || dgbi_resolution(distance, codes, camera) >= DGBI_BEYOND_FAR)
        return DGB_MAX_DISTANCE;
    return dgbi_resolution(distance / finer, codes, camera) > 0.0 ? (float)(distance / finer) : 0.0f;
}

DGB_API void dgb_position(float pixel_x, float pixel_y, float z, const dgb_camera* camera, float point[3]) {
    const float *pz = camera->position_z, *p1 = camera->position_1;
    point[0] = (pixel_x * pz[0] + pz[2]) * z + (pixel_x * p1[0] + p1[2]);
    point[1] = (pixel_y * pz[1] + pz[3]) * z + (pixel_y * p1[1] + p1[3]);
    point[2] = z;
}

DGB_API float dgb_pixels_per_metre(float z, const dgb_camera* camera) {
    const float w = camera->footprint[1] * z + camera->footprint[2];
    return dgbi_is_finite(w) && w > 0.0f ? camera->footprint[0] / w : 0.0f;
}

/* >> layers: keep test */

DGB_API bool dgb_keep_test(float z, float z_front, float separation) {
    if (dgbi_is_nan(z) || dgbi_is_nan(z_front) || dgbi_is_nan(separation)) return false;
    return z_front != 0.0f && -z > -z_front + separation;
}

/* >> ambient occlusion and radiosity: the terms */

DGB_API float dgb_ao_term(const float v[3], const float n[3], float inv_r2, float beta, float epsilon) {
    const float d2 = dgbi_dot(v, v);
    const float length = sqrtf(d2 + epsilon);
    const float cosine = length > 0.0f ? (dgbi_dot(v, n) - beta) / length : 0.0f;
    const float term = dgbi_max0(1.0f - d2 * inv_r2) * dgbi_max0(cosine);
    return dgbi_is_finite(term) ? term : 0.0f;
}

DGB_API float dgb_ambient_visibility(float sum, int count) {
    if (count < 1 || dgbi_is_nan(sum)) return 1.0f;
    return dgbi_max0(1.0f - sqrtf((float)DGBI_PI / (float)count * dgbi_max0(sum)));
}

DGB_API float dgb_gather_term(const float v[3], const float n_x[3], const float n_y[3], float r2, bool normal_test) {
    const float d2 = dgbi_dot(v, v);
    const float cosine = d2 > 0.0f ? dgbi_dot(v, n_x) / sqrtf(d2) : 0.0f;
    if (!dgbi_is_finite(cosine) || !(d2 <= r2) || !(cosine > DGB_MIN_COSINE)) return 0.0f;
    if (normal_test && !(dgbi_dot(v, n_y) < 0.0f)) return 0.0f;
    return cosine;
}

DGB_API float dgb_gather_scale(float sum_cos, int count, float k) {
    const float cosines = sum_cos * k, half = 0.5f * (float)count;
    if (count < 1) return 0.0f;
    return (float)DGBI_PI / (!dgbi_is_nan(cosines) && cosines > half ? cosines : half);
}

DGB_API float dgb_boost(const float albedo[3], float unsaturated, float saturated) {
    float high = 0.0f, low = dgbi_from_bits(0x7f7fffffu), s;
    int i;
    for (i = 0; i < 3; ++i) { /* NaN changes neither */
        if (dgbi_is_nan(albedo[i])) continue;
        high = albedo[i] > high ? albedo[i] : high;
        low = albedo[i] < low ? albedo[i] : low;
    }
    low = dgbi_max0(low);
    s = dgbi_is_finite(high) && high > low ? (high - low) / high : 0.0f;
    return unsaturated + (saturated - unsaturated) * s;
}

DGB_API float dgb_bilateral_weight(const float n[3], const float n2[3], const float dq[3], float normal_sharpness,
                                   float plane_sharpness) {
    const float normal = dgbi_max0(1.0f - normal_sharpness * (1.0f - dgbi_dot(n, n2)));
    const float d2 = dgbi_dot(dq, dq);
    const float off = fmaxf(fabsf(dgbi_dot(dq, n)), fabsf(dgbi_dot(dq, n2)));
    const float plane = d2 > 0.0f ? dgbi_max0(1.0f - plane_sharpness * off / sqrtf(d2)) : 1.0f;
    const float weight = normal * plane * plane;
    return dgbi_is_finite(weight) ? weight : 0.0f;
}

/* >> visibility bitmask: slices and sectors */

DGB_API float dgb_arc_sine(float x) {
    const float a = fabsf(x) > 1.0f ? 1.0f : fabsf(x);
    const float b =
        (float)(0.5 * DGBI_PI) - sqrtf(1.0f - a) * (1.5707288f + a * (-0.2121144f + a * (0.0742610f - 0.0187293f * a)));
    return x < 0.0f ? -b : b;
}

DGB_API void dgb_slice_along(const float n[3], const float v[3], const float s[3], float along[3]) {
    const float w[3] = {n[0] + s[0], n[1] + s[1], n[2] + s[2]}, towards = dgbi_dot(w, v);
    const float d[3] = {w[0] - towards * v[0], w[1] - towards * v[1], w[2] - towards * v[2]}, d2 = dgbi_dot(d, d);
    const bool valid = dgbi_is_finite(d2) && d2 > 1e-12f;
    int i;
    for (i = 0; i < 3; ++i) along[i] = valid ? d[i] / sqrtf(d2) : i == 0 ? 1.0f : 0.0f;
}

DGB_API void dgb_slice(const float n[3], const float v[3], const float along[3], float slice[4]) {
    const float towards = dgbi_max0(dgbi_dot(n, v)), across = dgbi_dot(n, along);
    const float length2 = towards * towards + across * across;
    const bool valid = dgbi_is_finite(length2) && length2 > 1e-12f;
    float whole;
    slice[0] = valid ? towards / sqrtf(length2) : 1.0f;
    slice[1] = valid ? across / sqrtf(length2) : 0.0f;
    slice[2] = dgb_arc_sine(slice[1]);
    whole = slice[0] + (slice[2] + (float)(0.5 * DGBI_PI)) * slice[1];
    slice[3] = 1.0f / (whole > 1e-5f ? whole : 1e-5f);
}

/* The integral of cos(t - g) sin t from 0 to an angle, times 2: with its sine s and cosine c, s^2 cos g + (angle - s c)
   sin g. x: 1 - c, the angle's versine. The polynomial makes the largest error of a share as small as four coefficients
   can. */
static float dgbi_slice_part(const float slice[4], float x) {
    const float segment = sqrtf(x) * (1.8772000f + x * (-0.3058190f + x * (0.0586256f - 0.0473906f * x)));
    return x * (slice[0] * (2.0f - x) + slice[1] * segment);
}

DGB_API float dgb_slice_share(const float slice[4], const float q[2]) {
    const float horizon = 1.0f + slice[1], whole = dgbi_slice_part(slice, horizon);
    const float length = sqrtf(q[0] * q[0] + q[1] * q[1] + 1e-30f);
    const float versine = fabsf(1.0f - q[0] / length); /* rounded, it may be below 0 */
    const float share = dgbi_slice_part(slice, versine) / (whole > 1e-5f ? whole : 1e-5f);
    if (!dgbi_is_finite(share) || !(q[1] >= 0.0f) || !(versine < horizon)) return 1.0f;
    return share > 0.0f ? (share < 1.0f ? share : 1.0f) : 0.0f;
}

/* The lowest `count` sectors. */
static uint32_t dgbi_lowest(uint32_t count) { return count < 32u ? (1u << count) - 1u : 0xffffffffu; }

/* Which sector's end a share rounds to; NaN and below 0: the first. */
static uint32_t dgbi_sector_end(float share, float u) {
    const float end = share * 32.0f + u;
    return dgbi_is_finite(end) && end > 0.0f ? (uint32_t)(end < 32.0f ? end : 32.0f) : 0u;
}

DGB_API uint32_t dgb_sectors(float from, float to, float u) {
    return dgbi_lowest(dgbi_sector_end(to, u)) & ~dgbi_lowest(dgbi_sector_end(from, u));
}

DGB_API int dgb_sector_count(uint32_t sectors) {
    const uint32_t pairs = sectors - (sectors >> 1 & 0x55555555u);
    const uint32_t fours = (pairs & 0x33333333u) + (pairs >> 2 & 0x33333333u);
    return (int)(((fours + (fours >> 4)) & 0x0f0f0f0fu) * 0x01010101u >> 24);
}

DGB_API float dgb_slice_angle(const float slice[4], float share) {
    const float horizon = slice[2] + (float)(0.5 * DGBI_PI);
    float t = horizon * (float)(2.0 / DGBI_PI) * dgb_arc_sine(sqrtf(share));
    int i;
    for (i = 0; i < 3; ++i) { /* Newton's; at the ends, where the share does not grow, t stays */
        const float s = sinf(t), c = cosf(t);
        const float off = (s * s * slice[0] + (t - s * c) * slice[1]) * slice[3] - share;
        const float slope = 2.0f * s * (c * slice[0] + s * slice[1]) * slice[3];
        t -= off / (slope > 1e-3f ? slope : 1e-3f);
        t = t > 0.0f ? (t < horizon ? t : horizon) : 0.0f;
    }
    return share < 1.0f ? t : horizon;
}

/* The integral of cos(t - g) sin t {cos t, sin t}. */
DGB_API void dgb_slice_sum(const float slice[4], float angle, float sum[2]) {
    const float s = sinf(angle), c = cosf(angle), s3 = s * s * s, c3 = c * c * c, scale = 2.0f / 3.0f * slice[3];
    sum[0] = (slice[0] * (1.0f - c3) + slice[1] * s3) * scale;
    sum[1] = (slice[0] * s3 + slice[1] * (2.0f - 3.0f * c + c3)) * scale;
}

/* Four sectors at a time, which lie so near together that any of them has their mean direction. */
DGB_API void dgb_sectors_mean(const float slice[4], uint32_t sectors, float sum[2]) {
    float before[2] = {0.0f, 0.0f};
    int i, k;
    sum[0] = sum[1] = 0.0f;
    for (i = 1; i <= 8; ++i) {
        const float part = 0.25f * (float)dgb_sector_count(sectors >> (4 * i - 4) & 15u);
        float up_to[2];
        dgb_slice_sum(slice, dgb_slice_angle(slice, 0.125f * (float)i), up_to);
        for (k = 0; k < 2; ++k) {
            sum[k] += (up_to[k] - before[k]) * part;
            before[k] = up_to[k];
        }
    }
}

/* The mean of a cone's directions is 2/3 (1 + c + c^2) / (1 + c) long; k is what is more than 2/3 of it, times 3/2. */
DGB_API float dgb_bent_cosine(const float bent[4]) {
    const bool open = !dgbi_is_nan(bent[3]) && bent[3] > 0.0f;
    const float length = sqrtf(dgbi_dot(bent, bent));
    const float k = dgbi_max0(1.5f * length / (open ? bent[3] : 1.0f) - 1.0f);
    const float cosine = 0.5f * (k + sqrtf(k * k + 4.0f * k));
    return dgbi_is_finite(cosine) && open && cosine < 1.0f ? cosine : 1.0f;
}

/* >> reflections: the lobe */

DGB_API float dgb_ggx_alpha(float roughness) {
    if (dgbi_is_nan(roughness) || roughness < DGB_MIN_ROUGHNESS) return 0.0f;
    return roughness < 1.0f ? roughness * roughness : 1.0f;
}

/* factor times the part of v in the surface, plus `up` times its normal, brought to unit length; false: it has none. */
static bool dgbi_stretch(const float v[3], const float n[3], float factor, float up, float out[3]) {
    const float along = dgbi_dot(v, n);
    float length;
    int i;
    for (i = 0; i < 3; ++i) out[i] = factor * (v[i] - along * n[i]) + up * n[i];
    length = sqrtf(dgbi_dot(out, out));
    if (!dgbi_is_finite(length) || !(length > 0.0f)) return false;
    for (i = 0; i < 3; ++i) out[i] /= length;
    return true;
}

/* Two unit vectors at right angles to n and to each other (Duff et al. 2017). */
static void dgbi_frame_of(const float n[3], float s[3], float t[3]) {
    const float side = n[2] < 0.0f ? -1.0f : 1.0f, a = -1.0f / (side + n[2]), b = n[0] * n[1] * a;
    s[0] = 1.0f + side * n[0] * n[0] * a;
    s[1] = side * b;
    s[2] = -side * n[0];
    t[0] = b;
    t[1] = side + n[1] * n[1] * a;
    t[2] = -n[1];
}

DGB_API void dgb_ggx_normal(const float v[3], const float n[3], float alpha, const float u[2], float h[3]) {
    static const float z[3] = {0.0f, 0.0f, 1.0f};
    const bool mirror = dgbi_is_nan(alpha) || !(alpha > 0.0f);
    float stretched[3], s[3], t[3], m[3], height, radius;
    bool valid;
    const double turn = 2.0 * DGBI_PI * (double)u[0];
    const float c = (float)cos(turn), d = (float)sin(turn);
    int i;
    valid = dgbi_stretch(v, n, alpha, dgbi_max0(dgbi_dot(v, n)), stretched);
    /* the cap of the unit sphere that the stretched viewer sees, uniformly: about n, from the pole to its horizon */
    height = 1.0f - u[1] * (1.0f + dgbi_dot(stretched, n));
    radius = sqrtf(dgbi_max0(1.0f - height * height));
    dgbi_frame_of(n, s, t);
    for (i = 0; i < 3; ++i) m[i] = stretched[i] + radius * (c * s[i] + d * t[i]) + height * n[i]; /* halfway */
    valid = dgbi_stretch(m, n, alpha, dgbi_dot(m, n), h) && valid;
    if (!mirror && (!valid || !(dgbi_dot(v, h) >= 0.0f))) memcpy(h, v, 3 * sizeof *h);
    if (mirror) memcpy(h, n, 3 * sizeof *h);
    if (!dgbi_all_finite(h, 3)) memcpy(h, z, sizeof z);
}

DGB_API float dgb_ggx_density(const float v[3], const float n[3], const float l[3], float alpha) {
    const float h[3] = {v[0] + l[0], v[1] + l[1], v[2] + l[2]}, h2 = dgbi_dot(h, h), up = dgbi_dot(h, n);
    const float off[3] = {n[1] * h[2] - n[2] * h[1], n[2] * h[0] - n[0] * h[2], n[0] * h[1] - n[1] * h[0]};
    const float a2 = alpha * alpha, k = a2 * up * up + dgbi_dot(off, off), along = dgbi_max0(dgbi_dot(v, n));
    const float masking = 2.0f * (along + sqrtf(a2 + (1.0f - a2) * along * along)); /* 4 n.v / G1 */
    const float below = (float)DGBI_PI * k * k * masking;
    const bool valid = dgbi_is_finite(alpha) && dgbi_is_finite(below) && alpha > 0.0f && up > 0.0f && below > 0.0f;
    const float density = valid ? a2 * h2 * h2 / below : 0.0f;
    return dgbi_is_finite(density) ? density : 0.0f;
}

/* >> parameters: presets, checks */

DGB_API dgb_params dgb_preset(dgb_preset_id id) {
    static const struct {
        int samples, filter_taps, min_level;
        bool normal_test;
        float guard_fraction;
    } table[DGB_PRESET_COUNT] = {{13, 9, 3, false, 0.1f}, {14, 11, 2, true, 0.5f}, {30, 13, 0, true, 0.8f}};
    const int row = (int)id >= 0 && id < DGB_PRESET_COUNT ? (int)id : (int)DGB_PRESET_BALANCED;
    dgb_params p;
    memset(&p, 0, sizeof p);
    p.separation = 0.5f;
    p.strict_separation = true;
    p.guard_fraction = table[row].guard_fraction;
    p.ao_radius = 1.0f;
    p.ao_samples = 16;
    p.ao_bias = 0.02f;
    p.ao_epsilon = 0.001f;
    p.ao_intensity = 1.0f;
    p.radius = 7.4f;
    p.samples = table[row].samples;
    p.normal_test = table[row].normal_test;
    p.min_level = table[row].min_level;
    p.slices = 1;
    p.thickness = 0.5f;
    p.bounce_damping = 1.0f;
    p.boost_unsaturated = 1.0f;
    p.boost_saturated = 1.0f;
    p.history_weight = 0.85f;
    p.history_tolerance = 0.005f;
    p.history_floor = 0.01f;
    p.reflect_distance = 30.0f;
    p.reflect_thickness = 0.5f;
    p.reflect_steps = 256;
    p.reflect_stride = 2;
    p.reflect_border = 32.0f;
    p.glossy_taps = 8;
    p.glossy_radius = 16.0f;
    p.adaptive = true;
    p.filter_taps = table[row].filter_taps;
    p.filter_step = 1;
    p.normal_sharpness = 4.0f;
    p.plane_sharpness = 2.0f;
    return p;
}

DGB_API dgb_estimator dgb_preset_estimator(dgb_preset_id id) {
    return id == DGB_PRESET_QUALITY ? DGB_ESTIMATOR_BITMASK : DGB_ESTIMATOR_PAPER;
}

typedef struct dgbi_budget {
    float cost;
    int taps, min_level, filter_taps;
    bool normal_test;
} dgbi_budget;

typedef struct dgbi_mirror_budget {
    float cost;
    int stride;
} dgbi_mirror_budget;

/* clang-format off */
/* budget: begin; written by `make budget`, do not edit */
static const dgbi_budget dgbi_ao_budget[] = {
    {0.41f, 4, 0, 1, true}, /* error 2.899 of BALANCED's */
    {0.48f, 8, 0, 1, true}, /* error 1.825 of BALANCED's */
    {0.57f, 4, 0, 5, true}, /* error 1.719 of BALANCED's */
    {0.59f, 14, 2, 1, true}, /* error 1.504 of BALANCED's */
    {0.60f, 14, 0, 1, true}, /* error 1.302 of BALANCED's */
    {0.64f, 8, 0, 5, true}, /* error 1.172 of BALANCED's */
    {0.74f, 14, 0, 5, true}, /* error 0.949 of BALANCED's */
    {0.89f, 30, 0, 1, true}, /* error 0.925 of BALANCED's */
    {1.05f, 30, 0, 5, true}, /* error 0.824 of BALANCED's */
    {1.51f, 64, 0, 1, true}, /* error 0.788 of BALANCED's */
};
static const dgbi_budget dgbi_light_budget[] = {
    {0.44f, 4, 2, 1, false}, /* error 2.069 of BALANCED's */
    {0.48f, 4, 2, 1, true}, /* error 2.020 of BALANCED's */
    {0.52f, 8, 2, 1, false}, /* error 1.779 of BALANCED's */
    {0.56f, 8, 2, 1, true}, /* error 1.730 of BALANCED's */
    {0.56f, 4, 2, 5, false}, /* error 1.327 of BALANCED's */
    {0.57f, 4, 2, 5, true}, /* error 1.295 of BALANCED's */
    {0.63f, 8, 2, 5, false}, /* error 1.200 of BALANCED's */
    {0.68f, 8, 2, 5, true}, /* error 1.164 of BALANCED's */
    {0.70f, 4, 2, 11, false}, /* error 1.141 of BALANCED's */
    {0.74f, 4, 2, 11, true}, /* error 1.117 of BALANCED's */
    {0.79f, 8, 2, 11, false}, /* error 1.075 of BALANCED's */
    {0.85f, 8, 2, 11, true}, /* error 1.044 of BALANCED's */
    {0.93f, 14, 2, 11, false}, /* error 1.030 of BALANCED's */
    {1.00f, 14, 2, 11, true}, /* error 1.000 of BALANCED's */
    {1.41f, 30, 2, 11, true}, /* error 0.979 of BALANCED's */
    {2.33f, 64, 2, 11, true}, /* error 0.964 of BALANCED's */
};
static const dgbi_mirror_budget dgbi_reflect_budget[] = {
    {0.45f, 16}, /* error 1.214 of BALANCED's */
    {0.48f, 12}, /* error 1.153 of BALANCED's */
    {0.57f, 6}, /* error 1.089 of BALANCED's */
    {0.78f, 3}, /* error 1.068 of BALANCED's */
    {1.00f, 2}, /* error 1.000 of BALANCED's */
    {1.63f, 1}, /* error 0.949 of BALANCED's */
};
/* budget: end */
/* clang-format on */

/* The last row that costs no more; the first if all do. */
static const dgbi_budget* dgbi_afford(const dgbi_budget* rows, int count, float budget) {
    int i = 0;
    while (i + 1 < count && rows[i + 1].cost <= budget) ++i;
    return rows + i;
}

DGB_API dgb_params dgb_preset_for(float budget, uint32_t effects) {
    dgb_params p = dgb_preset(DGB_PRESET_BALANCED);
    int i = 0;
    if (effects & DGB_EFFECT_AO) {
        const dgbi_budget* row = dgbi_afford(dgbi_ao_budget, DGBI_COUNT(dgbi_ao_budget), budget);
        p.ao_samples = row->taps;
        p.ao_min_level = row->min_level;
        p.filter_taps = row->filter_taps;
    }
    if (effects & DGB_EFFECT_RADIOSITY) {
        const dgbi_budget* row = dgbi_afford(dgbi_light_budget, DGBI_COUNT(dgbi_light_budget), budget);
        p.samples = row->taps;
        p.min_level = row->min_level;
        p.filter_taps = row->filter_taps;
        p.normal_test = row->normal_test;
    }
    while (i + 1 < DGBI_COUNT(dgbi_reflect_budget) && dgbi_reflect_budget[i + 1].cost <= budget) ++i;
    if (effects & DGB_EFFECT_REFLECT) p.reflect_stride = dgbi_reflect_budget[i].stride;
    return p;
}

static bool dgbi_at_least(float x, float low) { return dgbi_is_finite(x) && x >= low; }

/* Its square and the inverse of its square are finite, and nothing empty is within it. */
static bool dgbi_is_radius(float x) { return dgbi_at_least(x, DGB_MIN_RADIUS) && x <= DGB_MAX_RADIUS; }

static bool dgbi_in_range(int x, int low, int high) { return x >= low && x <= high; }

static dgb_log_item dgbi_check_params(const dgb_params* p) {
    if (!dgbi_at_least(p->separation, 0.0f)) return DGB_LOG_SEPARATION;
    if (!dgbi_at_least(p->guard_fraction, 0.0f) || p->guard_fraction > 1.0f) return DGB_LOG_GUARD_FRACTION;
    if (!dgbi_is_radius(p->ao_radius) || !dgbi_in_range(p->ao_samples, 1, DGB_MAX_TAPS) ||
        !dgbi_at_least(p->ao_bias, 0.0f) || !dgbi_at_least(p->ao_epsilon, 0.0f) ||
        !dgbi_at_least(p->ao_intensity, 0.0f))
        return DGB_LOG_AO_PARAMS;
    if (!dgbi_is_radius(p->radius) || !dgbi_in_range(p->samples, 1, DGB_MAX_TAPS)) return DGB_LOG_GATHER_PARAMS;
    if (!dgbi_in_range(p->slices, 1, DGB_MAX_SLICES) || !dgbi_at_least(p->thickness, 0.0f) ||
        p->thickness > DGB_MAX_RADIUS)
        return DGB_LOG_BITMASK_PARAMS;
    if (!dgbi_at_least(p->bounce_damping, 0.0f) || p->bounce_damping > 1.0f ||
        !dgbi_at_least(p->boost_unsaturated, 0.0f) || !dgbi_at_least(p->boost_saturated, 0.0f))
        return DGB_LOG_BOUNCE_PARAMS;
    if (!dgbi_at_least(p->history_weight, 0.0f) || p->history_weight > 0.999f ||
        !dgbi_at_least(p->history_tolerance, 0.0f) || !dgbi_at_least(p->history_floor, 0.0f) ||
        !dgbi_at_least(p->history_clamp, 0.0f) || !dgbi_at_least(p->sample_clamp, 0.0f))
        return DGB_LOG_HISTORY_PARAMS;
    if (!dgbi_is_radius(p->reflect_distance) || !dgbi_is_radius(p->reflect_thickness) ||
        !dgbi_in_range(p->reflect_steps, 1, 4096) || !dgbi_in_range(p->reflect_stride, 1, 64) ||
        !dgbi_at_least(p->reflect_border, 0.0f))
        return DGB_LOG_REFLECT_PARAMS;
    if (!dgbi_in_range(p->glossy_taps, 0, DGB_MAX_GLOSSY_TAPS) || !dgbi_at_least(p->glossy_radius, 0.0f))
        return DGB_LOG_GLOSSY_PARAMS;
    if (!dgbi_in_range(p->ao_min_level, 0, DGB_MAX_LEVELS - 1) || !dgbi_in_range(p->min_level, 0, DGB_MAX_LEVELS - 1))
        return DGB_LOG_MIP_PARAMS;
    if (!dgbi_in_range(p->filter_taps, 1, 2 * DGB_MAX_FILTER_RADIUS + 1) || p->filter_taps % 2 == 0 ||
        !dgbi_in_range(p->filter_step, 1, 8) || !dgbi_at_least(p->normal_sharpness, 0.0f) ||
        !dgbi_at_least(p->plane_sharpness, 0.0f))
        return DGB_LOG_FILTER_PARAMS;
    return DGB_LOG_NONE;
}

/* >> names */

DGB_API const char* dgb_result_name(dgb_result result) {
    static const char* const names[] = {"DGB_OK", "DGB_INVALID", "DGB_UNSUPPORTED", "DGB_OUT_OF_MEMORY", "DGB_DEVICE"};
    return dgbi_in_range((int)result, 0, DGB_DEVICE) ? names[result] : "?";
}

DGB_API const char* dgb_log_item_name(dgb_log_item item) {
#define DGBI_NAME(name, sentence) #name,
    static const char* const names[] = {"NONE", DGB_LOG_ITEMS(DGBI_NAME)};
#undef DGBI_NAME
    return dgbi_in_range((int)item, 0, DGB_LOG_COUNT - 1) ? names[item] : "?";
}

DGB_API const char* dgb_slot_name(dgb_slot slot) {
#define DGBI_NAME(slot, name) name,
    static const char* const names[] = {"none", DGB_SLOTS(DGBI_NAME)};
#undef DGBI_NAME
    return dgbi_in_range((int)slot, 0, DGB_SLOT_COUNT - 1) ? names[slot] : "?";
}

DGB_API const char* dgb_pass_name(dgb_pass_id pass) {
    static const char* const names[] = {"warp",     "layers",      "resolve", "back",    "predict",
                                        "pack",     "mip",         "tiles",   "ao",      "gather",
                                        "temporal", "reconstruct", "range",   "reflect", "glossy"};
    return dgbi_in_range((int)pass, 0, DGB_PASS_COUNT - 1) ? names[pass] : "?";
}

/* One row a format: name, bytes a texel. */
static const struct {
    const char* name;
    int bytes;
} dgbi_formats[DGB_FORMAT_COUNT] = {{"none", 0},       {"R8", 1},       {"RG8", 2},     {"RGBA8", 4},
                                    {"R11G11B10F", 4}, {"RG16F", 4},    {"RGBA16F", 8}, {"R32F", 4},
                                    {"RG32F", 8},      {"RGBA32F", 16}, {"R32UI", 4},   {"RG32UI", 8},
                                    {"RGBA32UI", 16},  {"D16", 2},      {"D24", 4},     {"D32F", 4}};

DGB_API const char* dgb_format_name(dgb_format format) {
    return dgbi_in_range((int)format, 0, DGB_FORMAT_COUNT - 1) ? dgbi_formats[format].name : "?";
}

DGB_API const char* dgb_oracle_name(dgb_oracle oracle) {
    static const char* const names[] = {"default", "peel", "previous", "reproject", "predict", "delay", "warp"};
    return dgbi_in_range((int)oracle, 0, DGB_ORACLE_COUNT - 1) ? names[oracle] : "?";
}

DGB_API const char* dgb_emission_name(dgb_emission emission) {
    static const char* const names[] = {"auto",  "separate", "geometry", "vertex", "instanced-geometry",
                                        "image", "multicast"};
    return dgbi_in_range((int)emission, 0, DGB_EMISSION_COUNT - 1) ? names[emission] : "?";
}

/* >> plan: what a desc asks for, as data */

static dgb_result dgbi_fail(const dgb_desc* desc, dgb_result result, dgb_log_item item) {
#define DGBI_SENTENCE(name, sentence) sentence,
    static const char* const sentences[] = {"", DGB_LOG_ITEMS(DGBI_SENTENCE)};
#undef DGBI_SENTENCE
    if (desc && desc->log) desc->log(desc->log_user, result, item, sentences[item]);
    return result;
}

static uint32_t dgbi_required_targets(uint32_t effects) {
    uint32_t targets = 0;
    if (effects) targets |= DGB_TARGET_NORMAL;
    if (effects & (DGB_EFFECT_RADIOSITY | DGB_EFFECT_REFLECT)) targets |= DGB_TARGET_RADIANCE;
    if ((effects & DGB_EFFECT_RADIOSITY) && (effects & (DGB_EFFECT_BOUNCES | DGB_EFFECT_REFLECT)))
        targets |= DGB_TARGET_ALBEDO;
    if (effects & DGB_EFFECT_BOUNCES) targets |= DGB_TARGET_VELOCITY;
    if (effects & DGB_EFFECT_TEMPORAL) targets |= DGB_TARGET_VELOCITY;
    return targets;
}

static bool dgbi_effects_ok(uint32_t effects) {
    const uint32_t all = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL |
                         DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY | DGB_EFFECT_BENT;
    if (effects & ~all) return false;
    if ((effects & DGB_EFFECT_BENT) && !(effects & DGB_EFFECT_AO)) return false;
    if ((effects & DGB_EFFECT_BOUNCES) && !(effects & DGB_EFFECT_RADIOSITY)) return false;
    if ((effects & DGB_EFFECT_GLOSSY) && !(effects & DGB_EFFECT_REFLECT)) return false;
    return !(effects & DGB_EFFECT_TEMPORAL) || (effects & (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_GLOSSY));
}

static bool dgbi_divisor_ok(const dgb_desc* d) {
    const int smaller = dgbi_min(d->width, d->height) + 2 * d->guard_band;
    if (d->divisor == 0 || d->divisor == 1) return true;
    return (d->divisor == 2 || d->divisor == 4) && d->divisor <= smaller && d->emission != DGB_EMISSION_IMAGE &&
           d->emission != DGB_EMISSION_MULTICAST;
}

static dgb_log_item dgbi_check_desc(const dgb_desc* d) {
    const uint32_t targets = d->targets ? d->targets : (uint32_t)DGB_TARGET_ALL;
    const int max_size = d->backend ? dgbi_min(d->backend->caps.max_size, DGB_MAX_SIZE) : DGB_MAX_SIZE;
    const int max_layers = d->source == DGB_SOURCE_ENGINE ? DGB_MAX_SHADED_LAYERS : DGB_MAX_LAYERS;
    if (!dgbi_in_range(d->width, 1, DGB_MAX_SIZE) || !dgbi_in_range(d->height, 1, DGB_MAX_SIZE)) return DGB_LOG_SIZE;
    if (!dgbi_in_range(d->guard_band, 0, DGB_MAX_SIZE) || d->width + 2 * d->guard_band > max_size ||
        d->height + 2 * d->guard_band > max_size)
        return DGB_LOG_GUARD_BAND;
    if (!dgbi_in_range(d->layers, 0, max_layers)) return DGB_LOG_LAYERS;
    if (d->backend && d->source == DGB_SOURCE_BUILD && (d->layers ? d->layers : 2) > d->backend->caps.max_layers)
        return DGB_LOG_LAYERS;
    if (!dgbi_effects_ok(d->effects) || ((d->effects & DGB_EFFECT_BENT) && d->estimator == DGB_ESTIMATOR_PAPER))
        return DGB_LOG_EFFECTS;
    if (!dgbi_in_range((int)d->source, 0, DGB_SOURCE_ENGINE) ||
        !dgbi_in_range((int)d->oracle, 0, DGB_ORACLE_COUNT - 1) ||
        !dgbi_in_range((int)d->emission, 0, DGB_EMISSION_COUNT - 1) ||
        !dgbi_in_range((int)d->clip, 0, DGB_CLIP_COUNT - 1) ||
        !dgbi_in_range((int)d->normals, 0, DGB_NORMALS_COUNT - 1) ||
        !dgbi_in_range((int)d->senders, 0, DGB_SENDERS_COUNT - 1) ||
        !dgbi_in_range((int)d->normaliser, 0, DGB_NORMALISER_COUNT - 1) ||
        !dgbi_in_range((int)d->tracer, 0, DGB_TRACER_COUNT - 1) ||
        !dgbi_in_range((int)d->estimator, 0, DGB_ESTIMATOR_COUNT - 1) ||
        !dgbi_in_range((int)d->thickness, 0, DGB_THICKNESS_COUNT - 1) ||
        (d->depth_format && !dgbi_in_range((int)d->depth_format, DGB_FORMAT_D16, DGB_FORMAT_D32F)))
        return DGB_LOG_ENUM;
    if (d->source == DGB_SOURCE_ENGINE)
        return d->oracle || d->emission || d->targets || !dgbi_in_range(d->divisor, 0, 1) ? DGB_LOG_SOURCE_OPTIONS
                                                                                          : DGB_LOG_NONE;
    if ((targets & ~(uint32_t)DGB_TARGET_ALL) || (dgbi_required_targets(d->effects) & ~targets)) return DGB_LOG_TARGETS;
    if (d->oracle == DGB_ORACLE_PEEL && d->emission > DGB_EMISSION_SEPARATE) return DGB_LOG_PEEL_EMISSION;
    if (!dgbi_divisor_ok(d)) return DGB_LOG_DIVISOR;
    return DGB_LOG_NONE;
}

static dgb_log_item dgbi_check_caps(const dgb_desc* d) {
    if (!d->backend || d->source == DGB_SOURCE_ENGINE) return DGB_LOG_NONE;
    if (d->emission && !d->backend->caps.emission[d->emission]) return DGB_LOG_EMISSION;
    if (d->clip == DGB_CLIP_ZERO_TO_ONE && !d->backend->caps.clip_zero_to_one) return DGB_LOG_CLIP;
    if (d->divisor > 1 && !d->backend->caps.deep_viewport) return DGB_LOG_DEEP_VIEWPORT;
    return DGB_LOG_NONE;
}

static dgb_emission dgbi_choose_emission(const dgb_desc* d) {
    if (d->oracle == DGB_ORACLE_PEEL || d->layers == 1) return DGB_EMISSION_SEPARATE;
    if (d->emission) return d->emission;
    if (d->backend && d->backend->caps.preferred &&
        !(d->backend->caps.preferred == DGB_EMISSION_IMAGE && d->divisor > 1))
        return d->backend->caps.preferred;
    if (!d->backend || d->backend->caps.emission[DGB_EMISSION_VERTEX]) return DGB_EMISSION_VERTEX;
    return d->backend->caps.emission[DGB_EMISSION_GEOMETRY] ? DGB_EMISSION_GEOMETRY : DGB_EMISSION_SEPARATE;
}

static void dgbi_resolve_defaults(dgb_desc* d) {
    if (!d->layers) d->layers = 2;
    if (!d->divisor) d->divisor = 1;
    if (!d->depth_format) d->depth_format = DGB_FORMAT_D32F;
    if (d->source == DGB_SOURCE_ENGINE) return;
    if (!d->targets) d->targets = DGB_TARGET_ALL;
    if (!d->oracle) d->oracle = d->layers == 1 ? DGB_ORACLE_PEEL : DGB_ORACLE_REPROJECT;
    d->emission = dgbi_choose_emission(d);
}

static bool dgbi_has_prediction(dgb_oracle oracle) {
    return oracle == DGB_ORACLE_PREDICT || oracle == DGB_ORACLE_DELAY;
}

static int dgbi_units(int pixels, int unit) { return (pixels + unit - 1) / unit; }

/* Cells of level m stand DGB_CELL_SIZE * 2^m pixels apart. None is longer than the buffer. */
static int dgbi_range_levels(const dgb_plan* plan) {
    const int longer = plan->width > plan->height ? plan->width : plan->height;
    return dgb_mip_levels(longer / DGB_CELL_SIZE, longer / DGB_CELL_SIZE);
}

/* Width and height of a texture of the plan. Ranges are for whole cells of their coarsest level: none is odd. */
static void dgbi_texture_size(const dgb_plan* plan, dgb_slot slot, int size[2]) {
    const int cells = slot == DGB_RANGES ? 1 << (dgbi_range_levels(plan) - 1) : 1;
    const int unit = slot == DGB_TILE_DEPTHS || slot == DGB_TILES ? DGB_TILE_SIZE
                     : slot == DGB_REGION_DEPTHS                  ? DGB_REGION_SIZE
                     : slot == DGB_RANGES                         ? DGB_CELL_SIZE * cells
                                                                  : 1;
    size[0] = slot == DGB_ROTATIONS ? DGB_ROTATION_COUNT : dgbi_units(plan->width, unit) * cells;
    size[1] = slot == DGB_ROTATIONS ? 1 : dgbi_units(plan->height, unit) * cells;
}

static void dgbi_add_texture(dgb_plan* plan, dgb_slot slot, dgb_format format, int layers, int levels) {
    dgb_texture_desc* t = &plan->textures[plan->texture_count++];
    int level, size[2];
    DGB_ASSERT(plan->texture_count <= DGB_MAX_TEXTURES);
    dgbi_texture_size(plan, slot, size);
    t->slot = slot;
    t->format = format;
    t->width = size[0];
    t->height = size[1];
    t->layers = layers;
    t->levels = levels;
    for (level = 0; level < levels; ++level)
        t->bytes += (uint64_t)(t->width >> level) * (uint64_t)(t->height >> level) * (uint64_t)(layers ? layers : 1) *
                    (uint64_t)dgbi_formats[format].bytes;
    plan->bytes += t->bytes;
}

static int dgbi_add_program(dgb_plan* plan, dgb_pass_id pass) {
    DGB_ASSERT(plan->program_count < DGB_MAX_PROGRAMS);
    plan->programs[plan->program_count].pass = pass;
    return plan->program_count++;
}

static void dgbi_add_define(dgb_plan* plan, const char* name, int value) {
    dgb_program_desc* program = &plan->programs[plan->program_count - 1];
    DGB_ASSERT(program->define_count < DGB_MAX_DEFINES);
    program->defines[program->define_count].name = name;
    program->defines[program->define_count].value = value;
    ++program->define_count;
}

static dgb_plan_pass* dgbi_add_pass(dgb_plan* plan, dgb_pass_id id, int level, int program) {
    dgb_plan_pass* pass = &plan->passes[plan->pass_count++];
    DGB_ASSERT(plan->pass_count <= DGB_MAX_PASSES);
    pass->id = id;
    pass->level = level;
    pass->program = program;
    return pass;
}

static void dgbi_add_input_as(dgb_plan_pass* pass, dgb_slot name, dgb_slot texture) {
    DGB_ASSERT(pass->input_count < DGB_MAX_INPUTS);
    pass->inputs[pass->input_count].name = name;
    pass->inputs[pass->input_count].texture = texture;
    ++pass->input_count;
}

static void dgbi_add_input(dgb_plan_pass* pass, dgb_slot slot) { dgbi_add_input_as(pass, slot, slot); }

static void dgbi_add_output(dgb_plan_pass* pass, dgb_slot slot) {
    DGB_ASSERT(pass->output_count < DGB_MAX_TARGETS);
    pass->outputs[pass->output_count++] = slot;
}

/* Run once for each layer that another is compared with. */
static void dgbi_plan_warp(dgb_plan* plan) {
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_WARP, 0, dgbi_add_program(plan, DGB_PASS_WARP));
    dgbi_add_input_as(pass, DGB_ORACLE, DGB_DEPTH);
    dgbi_add_output(pass, DGB_ORACLE);
}

/* Run once for each layer behind the first. */
static void dgbi_plan_resolve(const dgb_desc* d, dgb_plan* plan) {
    const int program = dgbi_add_program(plan, DGB_PASS_RESOLVE);
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_RESOLVE, 0, program);
    dgbi_add_texture(plan, DGB_KEY, DGB_FORMAT_R32UI, d->layers - 1, 1);
    dgbi_add_input(pass, DGB_KEY);
    dgbi_add_output(pass, DGB_DEPTH);
}

/* Depth of every layer but the last, of the next pose; the deeper ones are kept behind this pose's oracle. */
static void dgbi_plan_predict(const dgb_desc* d, dgb_plan* plan) {
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_PREDICT, 0, -1);
    dgbi_add_texture(plan, DGB_PREDICTED, d->depth_format, d->layers - 1, 1);
    if (d->layers > 2) dgbi_add_input(pass, DGB_ORACLE);
    dgbi_add_output(pass, DGB_PREDICTED);
}

/* What reads thickness wants to know where the back faces are. */
static bool dgbi_has_back(const dgb_desc* d) {
    const uint32_t covered = d->estimator == DGB_ESTIMATOR_BITMASK ? DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY : 0u;
    return d->thickness == DGB_THICKNESS_BACK_FACES && (d->effects & (covered | DGB_EFFECT_REFLECT));
}

/* Peeled off the first layer. */
static void dgbi_plan_back(const dgb_desc* d, dgb_plan* plan) {
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_BACK, 0, -1);
    dgbi_add_texture(plan, DGB_BACK, d->depth_format, 0, 1);
    dgbi_add_input_as(pass, DGB_ORACLE, DGB_DEPTH);
    dgbi_add_output(pass, DGB_BACK);
}

/* What the keep test of layers behind the first compares with, and what that takes. */
static void dgbi_plan_oracle(const dgb_desc* d, dgb_plan* plan, dgb_plan_pass* pass) {
    const bool whole = d->oracle == DGB_ORACLE_PREVIOUS || d->oracle == DGB_ORACLE_REPROJECT; /* last frame's depth */
    if (d->layers == 1) return; /* nothing to compare with */
    if (d->oracle == DGB_ORACLE_PEEL) {
        dgbi_add_input_as(pass, DGB_ORACLE, DGB_DEPTH);
        return;
    }
    dgbi_add_texture(plan, DGB_ORACLE, d->depth_format, whole ? d->layers : d->layers - 1, 1);
    dgbi_add_input(pass, DGB_ORACLE);
    if (d->emission == DGB_EMISSION_IMAGE) dgbi_plan_resolve(d, plan);
}

static void dgbi_plan_layers(const dgb_desc* d, dgb_plan* plan) {
    static const struct {
        uint32_t target;
        dgb_slot slot;
        dgb_format format;
    } colors[] = {{DGB_TARGET_ALBEDO, DGB_ALBEDO, DGB_FORMAT_RGBA8},
                  {DGB_TARGET_NORMAL, DGB_NORMAL, DGB_FORMAT_RGBA8},
                  {DGB_TARGET_RADIANCE, DGB_RADIANCE, DGB_FORMAT_R11G11B10F},
                  {DGB_TARGET_VELOCITY, DGB_VELOCITY, DGB_FORMAT_RG16F}};
    dgb_plan_pass* pass;
    int i;
    if (d->oracle == DGB_ORACLE_WARP && d->layers > 1) dgbi_plan_warp(plan);
    pass = dgbi_add_pass(plan, DGB_PASS_LAYERS, 0, -1);
    dgbi_add_texture(plan, DGB_DEPTH, d->depth_format, d->layers, 1);
    for (i = 0; i < DGBI_COUNT(colors); ++i)
        if (d->targets & colors[i].target) {
            dgbi_add_texture(plan, colors[i].slot, colors[i].format, d->layers, 1);
            dgbi_add_output(pass, colors[i].slot);
        }
    dgbi_plan_oracle(d, plan, pass);
    if (dgbi_has_back(d)) dgbi_plan_back(d, plan);
    if (d->layers > 1 && dgbi_has_prediction(d->oracle)) dgbi_plan_predict(d, plan);
}

/* What the shading wants, besides what every desc has. */
typedef struct dgbi_wants {
    int layers; /* shaded */
    bool ao, bent, light, bounces, temporal, reflect, glossy;
    bool spiral;   /* something takes spiral taps: occlusion or light */
    bool radiance; /* is packed */
    bool deep;     /* the second layer receives light as well */
    bool indirect; /* reflections add what this frame's irradiance makes of the surface that is hit */
    bool back;     /* back faces end the first layer */
} dgbi_wants;

static dgbi_wants dgbi_wants_of(const dgb_desc* d) {
    dgbi_wants w;
    w.layers = dgbi_min(d->layers, DGB_MAX_SHADED_LAYERS);
    w.ao = (d->effects & DGB_EFFECT_AO) != 0;
    w.bent = (d->effects & DGB_EFFECT_BENT) != 0;
    w.light = (d->effects & DGB_EFFECT_RADIOSITY) != 0;
    w.bounces = (d->effects & DGB_EFFECT_BOUNCES) != 0;
    w.temporal = (d->effects & DGB_EFFECT_TEMPORAL) != 0;
    w.reflect = (d->effects & DGB_EFFECT_REFLECT) != 0;
    w.glossy = (d->effects & DGB_EFFECT_GLOSSY) != 0;
    w.spiral = w.ao || w.light;
    w.radiance = w.light || w.reflect;
    w.indirect = w.reflect && w.light && !w.bounces; /* bounces are part of the packed radiance already */
    w.deep = (w.bounces || w.indirect) && w.layers > 1;
    w.back = dgbi_has_back(d);
    return w;
}

/* What is read of the first `layers` layers: the library's texture, or the engine's own, one a layer. */
static void dgbi_add_source(const dgb_desc* d, dgb_slot built, dgb_slot engine0, int layers, dgb_plan_pass* pass) {
    if (d->source == DGB_SOURCE_BUILD) {
        dgbi_add_input(pass, built);
        return;
    }
    dgbi_add_input(pass, engine0);
    if (layers > 1) dgbi_add_input(pass, (dgb_slot)(engine0 + 1));
}

static void dgbi_add_packed_outputs(dgb_plan_pass* pass, bool normals, bool radiance, int layers) {
    dgbi_add_output(pass, DGB_Z);
    if (normals) dgbi_add_output(pass, DGB_NORMALS);
    if (radiance) dgbi_add_output(pass, DGB_B0);
    if (radiance && layers > 1) dgbi_add_output(pass, DGB_B1);
}

static void dgbi_plan_pack_inputs(const dgb_desc* d, const dgbi_wants* w, dgb_plan_pass* pass) {
    dgbi_add_source(d, DGB_DEPTH, DGB_ENGINE_DEPTH0, w->layers, pass);
    if (w->back) dgbi_add_source(d, DGB_BACK, DGB_ENGINE_BACK, 1, pass);
    if (d->source == DGB_SOURCE_BUILD || d->normals != DGB_NORMALS_FROM_DEPTH)
        dgbi_add_source(d, DGB_NORMAL, DGB_ENGINE_NORMAL0, w->layers, pass);
    if (w->radiance) dgbi_add_source(d, DGB_RADIANCE, DGB_ENGINE_RADIANCE0, w->layers, pass);
    if (!w->bounces) return;
    dgbi_add_source(d, DGB_ALBEDO, DGB_ENGINE_ALBEDO0, w->layers, pass);
    dgbi_add_source(d, DGB_VELOCITY, DGB_ENGINE_VELOCITY0, w->layers, pass);
    dgbi_add_input(pass, DGB_LAST_Z);
    dgbi_add_input_as(pass, DGB_LAST_IRRADIANCE, DGB_IRRADIANCE); /* not written again until the reconstruction */
    if (w->deep) dgbi_add_input_as(pass, DGB_LAST_IRRADIANCE1, DGB_IRRADIANCE1);
}

static void dgbi_plan_pack(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    const int program = dgbi_add_program(plan, DGB_PASS_PACK);
    const dgb_format z = w->back ? DGB_FORMAT_RGBA32F : w->layers > 1 ? DGB_FORMAT_RG32F : DGB_FORMAT_R32F;
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_PACK, 0, program);
    dgbi_add_define(plan, "DGB_LAYERS", w->layers);
    dgbi_add_define(plan, "DGB_ENGINE_LAYERS", d->source == DGB_SOURCE_ENGINE);
    dgbi_add_define(plan, "DGB_NORMALS_FORMAT",
                    d->source == DGB_SOURCE_ENGINE ? (int)d->normals : (int)DGB_NORMALS_OCT16);
    dgbi_add_define(plan, "DGB_PACK_RADIANCE", w->radiance);
    dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
    dgbi_add_define(plan, "DGB_LAST_LIGHT", w->bounces);
    dgbi_add_define(plan, "DGB_DEEP", w->bounces && w->deep);
    dgbi_add_define(plan, "DGB_BACK", w->back);
    dgbi_add_texture(plan, DGB_Z, z, 0, w->spiral ? plan->levels : 1);
    if (w->bounces || w->temporal)
        dgbi_add_texture(plan, DGB_LAST_Z, z, 0, w->spiral ? plan->levels : 1); /* takes turns with z */
    dgbi_add_texture(plan, DGB_NORMALS, w->layers > 1 ? DGB_FORMAT_RGBA8 : DGB_FORMAT_RG8, 0,
                     w->light ? plan->levels : 1);
    if (w->radiance) dgbi_add_texture(plan, DGB_B0, DGB_FORMAT_R11G11B10F, 0, w->light ? plan->levels : 1);
    if (w->radiance && w->layers > 1)
        dgbi_add_texture(plan, DGB_B1, DGB_FORMAT_R11G11B10F, 0, w->light ? plan->levels : 1);
    dgbi_plan_pack_inputs(d, w, pass);
    dgbi_add_packed_outputs(pass, true, w->radiance, w->layers);
}

/* Occlusion taps read z alone; radiosity reads everything at every level. The programs here and below do not depend on
   the size, even where a small one leaves some of them no pass: dgb_resize keeps them. */
static void dgbi_plan_mip(const dgbi_wants* w, dgb_plan* plan) {
    const int program = dgbi_add_program(plan, DGB_PASS_MIP);
    int level, i;
    dgbi_add_define(plan, "DGB_LAYERS", w->layers);
    dgbi_add_define(plan, "DGB_PACK_RADIANCE", w->light);
    for (level = 1; level < plan->levels; ++level) {
        dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_MIP, level, program);
        dgbi_add_packed_outputs(pass, w->light, w->light, w->layers);
        for (i = 0; i < pass->output_count; ++i) dgbi_add_input(pass, pass->outputs[i]);
    }
}

/* Depth ranges of tiles, of regions, then what matters where. Needless where there is no second layer. */
static void dgbi_plan_tiles(dgb_plan* plan) {
    static const struct {
        dgb_slot output;
        dgb_format format;
        dgb_slot inputs[2];
    } steps[3] = {{DGB_TILE_DEPTHS, DGB_FORMAT_RGBA32F, {DGB_Z, DGB_SLOT_NONE}},
                  {DGB_REGION_DEPTHS, DGB_FORMAT_RGBA32F, {DGB_TILE_DEPTHS, DGB_SLOT_NONE}},
                  {DGB_TILES, DGB_FORMAT_RGBA8, {DGB_TILE_DEPTHS, DGB_REGION_DEPTHS}}};
    int step;
    for (step = 0; step < 3; ++step) {
        dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_TILES, step, dgbi_add_program(plan, DGB_PASS_TILES));
        dgbi_add_define(plan, "DGB_TILES_STEP", step);
        dgbi_add_texture(plan, steps[step].output, steps[step].format, 0, 1);
        dgbi_add_input(pass, steps[step].inputs[0]);
        if (steps[step].inputs[1]) dgbi_add_input(pass, steps[step].inputs[1]);
        dgbi_add_output(pass, steps[step].output);
    }
}

static void dgbi_plan_ao(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    const int program = dgbi_add_program(plan, DGB_PASS_AO);
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_AO, 0, program);
    dgbi_add_define(plan, "DGB_LAYERS", w->layers);
    dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
    if (d->estimator == DGB_ESTIMATOR_BITMASK) {
        dgbi_add_define(plan, "DGB_NORMAL_TEST", 0);
        dgbi_add_define(plan, "DGB_BITMASK_LIGHT", 0);
        dgbi_add_define(plan, "DGB_THICKNESS", (int)d->thickness);
        dgbi_add_define(plan, "DGB_BENT", w->bent);
    }
    dgbi_add_texture(plan, DGB_AO_RAW, DGB_FORMAT_R8, 0, 1);
    if (w->bent) dgbi_add_texture(plan, DGB_BENT_RAW, DGB_FORMAT_RGBA16F, 0, 1);
    dgbi_add_input(pass, DGB_Z);
    dgbi_add_input(pass, DGB_NORMALS);
    dgbi_add_input(pass, DGB_ROTATIONS);
    if (w->layers > 1) dgbi_add_input(pass, DGB_TILES);
    dgbi_add_output(pass, DGB_AO_RAW);
    if (w->bent) dgbi_add_output(pass, DGB_BENT_RAW);
}

/* Two programs, so that presets switch without compiling: the first without the normal test, the next with it. */
static void dgbi_plan_gather(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    const int program = plan->program_count;
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_GATHER, 0, program);
    int normal_test;
    for (normal_test = 0; normal_test < 2; ++normal_test) {
        dgbi_add_program(plan, DGB_PASS_GATHER);
        dgbi_add_define(plan, "DGB_LAYERS", w->layers);
        dgbi_add_define(plan, "DGB_NORMAL_TEST", normal_test);
        if (d->estimator == DGB_ESTIMATOR_PAPER)
            dgbi_add_define(plan, "DGB_STRONGEST_SENDER", d->senders == DGB_SENDERS_STRONGEST);
        dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
        dgbi_add_define(plan, "DGB_DEEP", w->deep);
        if (d->estimator != DGB_ESTIMATOR_BITMASK) continue;
        dgbi_add_define(plan, "DGB_BITMASK_LIGHT", 1);
        dgbi_add_define(plan, "DGB_THICKNESS", (int)d->thickness);
        dgbi_add_define(plan, "DGB_BENT", 0);
    }
    dgbi_add_texture(plan, DGB_IRRADIANCE_RAW, DGB_FORMAT_RGBA16F, 0, 1);
    if (w->deep) dgbi_add_texture(plan, DGB_IRRADIANCE1_RAW, DGB_FORMAT_RGBA16F, 0, 1);
    dgbi_add_input(pass, DGB_Z);
    dgbi_add_input(pass, DGB_NORMALS);
    dgbi_add_input(pass, DGB_B0);
    if (w->layers > 1) dgbi_add_input(pass, DGB_B1);
    dgbi_add_input(pass, DGB_ROTATIONS);
    if (w->layers > 1) dgbi_add_input(pass, DGB_TILES);
    dgbi_add_output(pass, DGB_IRRADIANCE_RAW);
    if (w->deep) dgbi_add_output(pass, DGB_IRRADIANCE1_RAW);
}

/* A raw result, its average, and the average of last frame, which take turns. */
static void dgbi_plan_mean(dgb_slot raw, dgb_slot mean, dgb_slot last, dgb_plan* plan, dgb_plan_pass* pass) {
    dgbi_add_texture(plan, mean, DGB_FORMAT_RGBA16F, 0, 1);
    dgbi_add_texture(plan, last, DGB_FORMAT_RGBA16F, 0, 1);
    if (raw) dgbi_add_input(pass, raw);
    dgbi_add_input(pass, last);
    dgbi_add_output(pass, mean);
}

/* Two programs, the second with limits to what stands out, which cost nothing where there are none. */
static void dgbi_plan_temporal(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_TEMPORAL, 0, plan->program_count);
    int limited;
    for (limited = 0; limited < 2; ++limited) {
        dgbi_add_program(plan, DGB_PASS_TEMPORAL);
        dgbi_add_define(plan, "DGB_ENGINE_LAYERS", d->source == DGB_SOURCE_ENGINE);
        dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
        dgbi_add_define(plan, "DGB_FILTER_AO", w->ao);
        dgbi_add_define(plan, "DGB_LAST_LIGHT", w->light);
        dgbi_add_define(plan, "DGB_DEEP", w->deep);
        dgbi_add_define(plan, "DGB_BENT", w->bent);
        dgbi_add_define(plan, "DGB_LIMITED", limited);
    }
    dgbi_add_input(pass, DGB_Z);
    dgbi_add_input(pass, DGB_NORMALS);
    dgbi_add_input(pass, DGB_LAST_Z);
    dgbi_add_source(d, DGB_VELOCITY, DGB_ENGINE_VELOCITY0, w->deep ? 2 : 1, pass);
    dgbi_plan_mean(w->ao ? DGB_AO_RAW : DGB_SLOT_NONE, DGB_FRAMES, DGB_LAST_FRAMES, plan, pass);
    if (w->light) dgbi_plan_mean(DGB_IRRADIANCE_RAW, DGB_IRRADIANCE_MEAN, DGB_LAST_IRRADIANCE, plan, pass);
    if (w->deep) dgbi_plan_mean(DGB_IRRADIANCE1_RAW, DGB_IRRADIANCE1_MEAN, DGB_LAST_IRRADIANCE1, plan, pass);
    if (w->bent) dgbi_plan_mean(DGB_BENT_RAW, DGB_BENT_MEAN, DGB_LAST_BENT, plan, pass);
}

/* A result that the reconstruction filters: what the shader calls it, where it lies, where the filtered one goes. */
typedef struct dgbi_filtered {
    bool wanted;
    dgb_slot name, before, after;
    dgb_format format;
} dgbi_filtered;

/* Along x it reads what earlier passes have left, along y what it wrote itself: surface and light in one texel. */
static void dgbi_plan_axis(const dgb_desc* d, const dgbi_wants* w, int axis, dgb_plan* plan) {
    const dgbi_filtered results[4] = {
        {w->ao, DGB_AO_RAW, w->temporal ? DGB_FRAMES : DGB_AO_RAW, DGB_AO, DGB_FORMAT_R8},
        {w->light, DGB_IRRADIANCE_RAW, w->temporal ? DGB_IRRADIANCE_MEAN : DGB_IRRADIANCE_RAW, DGB_IRRADIANCE,
         DGB_FORMAT_RGBA16F},
        {w->deep, DGB_IRRADIANCE1_RAW, w->temporal ? DGB_IRRADIANCE1_MEAN : DGB_IRRADIANCE1_RAW, DGB_IRRADIANCE1,
         DGB_FORMAT_RGBA16F},
        {w->bent, DGB_BENT_RAW, w->temporal ? DGB_BENT_MEAN : DGB_BENT_RAW, DGB_BENT, DGB_FORMAT_RGBA16F}};
    const dgb_slot halves[2] = {DGB_HALF, DGB_HALF1};
    const int program = dgbi_add_program(plan, DGB_PASS_RECONSTRUCT);
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_RECONSTRUCT, axis, program);
    int i;
    dgbi_add_define(plan, "DGB_AXIS", axis);
    dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
    dgbi_add_define(plan, "DGB_FILTER_AO", w->ao);
    dgbi_add_define(plan, "DGB_FILTER_IRRADIANCE", w->light);
    dgbi_add_define(plan, "DGB_DEEP", w->deep);
    dgbi_add_define(plan, "DGB_BENT", w->bent);
    if (axis == 0) dgbi_add_input(pass, DGB_Z), dgbi_add_input(pass, DGB_NORMALS);
    for (i = 0; i < (w->deep ? 2 : 1); ++i) {
        if (axis == 0) dgbi_add_texture(plan, halves[i], w->light ? DGB_FORMAT_RGBA32UI : DGB_FORMAT_RG32UI, 0, 1);
        if (axis == 0) dgbi_add_output(pass, halves[i]);
        if (axis == 1) dgbi_add_input(pass, halves[i]);
    }
    if (w->bent && axis == 0) {
        dgbi_add_texture(plan, DGB_HALF_BENT, DGB_FORMAT_RGBA16F, 0, 1);
        dgbi_add_output(pass, DGB_HALF_BENT);
    } else if (w->bent) {
        dgbi_add_input(pass, DGB_HALF_BENT);
    }
    for (i = 0; i < 4; ++i) {
        if (!results[i].wanted) continue;
        if (axis == 0) dgbi_add_input_as(pass, results[i].name, results[i].before);
        if (axis == 1) dgbi_add_texture(plan, results[i].after, results[i].format, 0, 1);
        if (axis == 1) dgbi_add_output(pass, results[i].after);
    }
}

static void dgbi_plan_reconstruct(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    int axis;
    for (axis = 0; axis < 2; ++axis) dgbi_plan_axis(d, w, axis, plan);
}

/* The finest level from z, each of the others from the one before. */
static void dgbi_plan_range(const dgbi_wants* w, dgb_plan* plan) {
    const int levels = dgbi_range_levels(plan), first = plan->program_count;
    int level;
    for (level = 0; level < 2; ++level) {
        dgbi_add_program(plan, DGB_PASS_RANGE);
        dgbi_add_define(plan, "DGB_RANGE_STEP", level);
    }
    dgbi_add_texture(plan, DGB_RANGES, w->layers > 1 ? DGB_FORMAT_RGBA32F : DGB_FORMAT_RG32F, 0, levels);
    for (level = 0; level < levels; ++level) {
        dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_RANGE, level, first + (level > 0));
        dgbi_add_input(pass, level ? DGB_RANGES : DGB_Z);
        dgbi_add_output(pass, DGB_RANGES);
    }
}

static void dgbi_plan_reflect(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    const int program = dgbi_add_program(plan, DGB_PASS_REFLECT);
    const dgb_slot reflection = w->glossy ? DGB_REFLECTION_RAW : DGB_REFLECTION;
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_REFLECT, 0, program);
    dgbi_add_define(plan, "DGB_LAYERS", w->layers);
    dgbi_add_define(plan, "DGB_ENGINE_LAYERS", d->source == DGB_SOURCE_ENGINE);
    dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
    dgbi_add_define(plan, "DGB_HIERARCHICAL", d->tracer == DGB_TRACER_HIERARCHICAL);
    dgbi_add_define(plan, "DGB_INDIRECT", w->indirect);
    dgbi_add_define(plan, "DGB_GLOSSY", w->glossy);
    dgbi_add_define(plan, "DGB_THICKNESS", (int)d->thickness);
    dgbi_add_texture(plan, reflection, DGB_FORMAT_RGBA16F, 0, 1);
    dgbi_add_texture(plan, DGB_REFLECTION_HIT, w->glossy ? DGB_FORMAT_RGBA16F : DGB_FORMAT_RG16F, 0, 1);
    dgbi_add_input(pass, DGB_Z);
    dgbi_add_input(pass, DGB_NORMALS);
    dgbi_add_input(pass, DGB_B0);
    if (w->layers > 1) dgbi_add_input(pass, DGB_B1);
    if (d->tracer == DGB_TRACER_HIERARCHICAL) dgbi_add_input(pass, DGB_RANGES);
    if (w->indirect) {
        dgbi_add_source(d, DGB_ALBEDO, DGB_ENGINE_ALBEDO0, w->layers, pass);
        dgbi_add_input(pass, DGB_IRRADIANCE);
        if (w->deep) dgbi_add_input(pass, DGB_IRRADIANCE1);
    }
    if (w->glossy) dgbi_add_source(d, DGB_NORMAL, DGB_ENGINE_ROUGHNESS, 1, pass); /* of the layer that mirrors */
    dgbi_add_output(pass, reflection);
    dgbi_add_output(pass, DGB_REFLECTION_HIT);
}

/* The average over frames is the result, and takes turns with last frame's. */
static void dgbi_plan_glossy(const dgb_desc* d, const dgbi_wants* w, dgb_plan* plan) {
    const int program = dgbi_add_program(plan, DGB_PASS_GLOSSY);
    dgb_plan_pass* pass = dgbi_add_pass(plan, DGB_PASS_GLOSSY, 0, program);
    dgbi_add_define(plan, "DGB_ENGINE_LAYERS", d->source == DGB_SOURCE_ENGINE);
    dgbi_add_define(plan, "DGB_DIVISOR", d->divisor);
    dgbi_add_define(plan, "DGB_LAST_LIGHT", 0);
    dgbi_add_define(plan, "DGB_DEEP", 0); /* what mirrors has been in view */
    dgbi_add_define(plan, "DGB_HISTORY", w->temporal);
    dgbi_add_texture(plan, DGB_REFLECTION, DGB_FORMAT_RGBA16F, 0, 1);
    dgbi_add_input(pass, DGB_Z);
    dgbi_add_input(pass, DGB_NORMALS);
    dgbi_add_source(d, DGB_NORMAL, DGB_ENGINE_ROUGHNESS, 1, pass);
    dgbi_add_input(pass, DGB_REFLECTION_RAW);
    dgbi_add_input(pass, DGB_REFLECTION_HIT);
    dgbi_add_output(pass, DGB_REFLECTION);
    if (!w->temporal) return;
    dgbi_add_texture(plan, DGB_LAST_REFLECTION, DGB_FORMAT_RGBA16F, 0, 1);
    dgbi_add_texture(plan, DGB_REFLECTION_FRAMES, DGB_FORMAT_R8, 0, 1);
    dgbi_add_texture(plan, DGB_LAST_REFLECTION_FRAMES, DGB_FORMAT_R8, 0, 1);
    dgbi_add_input(pass, DGB_LAST_Z);
    dgbi_add_source(d, DGB_VELOCITY, DGB_ENGINE_VELOCITY0, 1, pass);
    dgbi_add_input(pass, DGB_LAST_REFLECTION);
    dgbi_add_input(pass, DGB_LAST_REFLECTION_FRAMES);
    dgbi_add_output(pass, DGB_REFLECTION_FRAMES);
}

static void dgbi_fill_plan(const dgb_desc* d, dgb_plan* plan) {
    const dgbi_wants wants = dgbi_wants_of(d);
    memset(plan, 0, sizeof *plan);
    plan->width = d->width + 2 * d->guard_band;
    plan->height = d->height + 2 * d->guard_band;
    plan->layers = d->layers;
    plan->levels = dgb_mip_levels(plan->width, plan->height);
    plan->oracle = d->oracle;
    plan->emission = d->emission;
    if (d->source == DGB_SOURCE_BUILD) dgbi_plan_layers(d, plan);
    if (!d->effects) return;
    if (wants.spiral) dgbi_add_texture(plan, DGB_ROTATIONS, DGB_FORMAT_RG32F, 0, 1);
    dgbi_plan_pack(d, &wants, plan);
    if (wants.spiral) dgbi_plan_mip(&wants, plan);
    if (wants.spiral && wants.layers > 1) dgbi_plan_tiles(plan);
    if (wants.ao) dgbi_plan_ao(d, &wants, plan);
    if (wants.light) dgbi_plan_gather(d, &wants, plan);
    if (wants.temporal && wants.spiral) dgbi_plan_temporal(d, &wants, plan);
    if (wants.spiral) dgbi_plan_reconstruct(d, &wants, plan);
    if (wants.reflect && d->tracer == DGB_TRACER_HIERARCHICAL) dgbi_plan_range(&wants, plan);
    if (wants.reflect) dgbi_plan_reflect(d, &wants, plan);
    if (wants.glossy) dgbi_plan_glossy(d, &wants, plan);
}

DGB_API dgb_result dgb_make_plan(const dgb_desc* desc, dgb_plan* plan) {
    dgb_log_item item;
    dgb_desc resolved;
    if (!desc || !plan) return dgbi_fail(desc, DGB_INVALID, DGB_LOG_NULL_ARGUMENT);
    item = dgbi_check_desc(desc);
    if (item != DGB_LOG_NONE) return dgbi_fail(desc, DGB_INVALID, item);
    item = dgbi_check_caps(desc);
    if (item != DGB_LOG_NONE) return dgbi_fail(desc, DGB_UNSUPPORTED, item);
    resolved = *desc;
    dgbi_resolve_defaults(&resolved);
    dgbi_fill_plan(&resolved, plan);
    return DGB_OK;
}

/* >> context: init, resize, shutdown */

#define DGBI_INITIALISED 0x44474221u

static dgb_log_item dgbi_check_backend(const dgb_backend* b) {
    if (!b) return DGB_LOG_NULL_ARGUMENT;
    if (b->version != DGB_VERSION) return DGB_LOG_BACKEND_VERSION;
    if (!b->texture_create || !b->texture_destroy || !b->program_create || !b->program_destroy || !b->pass_begin ||
        !b->texture_bind || !b->uniforms_upload || !b->draw_fullscreen || !b->pass_end)
        return DGB_LOG_BACKEND_CALLBACK;
    return DGB_LOG_NONE;
}

static void dgbi_begin(const dgb_backend* b) {
    if (b->begin) b->begin(b->user);
}

static dgb_result dgbi_end(const dgb_backend* b) { return b->end ? b->end(b->user) : DGB_OK; }

/* All but the engine's own, which are only remembered. */
static void dgbi_destroy_textures(const dgb_backend* b, dgb_texture textures[DGB_SLOT_COUNT]) {
    int slot;
    for (slot = 0; slot < DGB_SLOT_COUNT; ++slot) {
        const bool borrowed = slot >= DGB_ENGINE_DEPTH0 && slot <= DGB_ENGINE_ROUGHNESS;
        if (textures[slot].id && !borrowed) b->texture_destroy(b->user, textures[slot]);
        textures[slot].id = 0;
    }
}

static dgb_result dgbi_create_textures(const dgb_backend* b, const dgb_plan* plan,
                                       dgb_texture textures[DGB_SLOT_COUNT]) {
    float rotations[DGB_ROTATION_COUNT][2];
    int i;
    for (i = 0; i < DGB_ROTATION_COUNT; ++i) dgb_rotation(i, rotations[i]);
    memset(textures, 0, sizeof(dgb_texture) * DGB_SLOT_COUNT);
    for (i = 0; i < plan->texture_count; ++i) {
        dgb_texture_desc t = plan->textures[i];
        dgb_result result;
        if (t.slot == DGB_ROTATIONS) t.pixels = rotations;
        result = b->texture_create(b->user, &t, &textures[t.slot]);
        if (result == DGB_OK && textures[t.slot].id) continue;
        textures[t.slot].id = 0;
        dgbi_destroy_textures(b, textures);
        return result == DGB_OK ? DGB_DEVICE : result;
    }
    return DGB_OK;
}

static void dgbi_destroy_programs(const dgb_backend* b, dgb_program programs[DGB_MAX_PROGRAMS]) {
    int i;
    for (i = 0; i < DGB_MAX_PROGRAMS; ++i)
        if (programs[i].id) {
            b->program_destroy(b->user, programs[i]);
            programs[i].id = 0;
        }
}

static dgb_result dgbi_create_programs(const dgb_backend* b, const dgb_plan* plan,
                                       dgb_program programs[DGB_MAX_PROGRAMS]) {
    int i;
    for (i = 0; i < plan->program_count; ++i) {
        const dgb_result result = b->program_create(b->user, &plan->programs[i], &programs[i]);
        if (result == DGB_OK && programs[i].id) continue;
        programs[i].id = 0;
        dgbi_destroy_programs(b, programs);
        return result == DGB_OK ? DGB_DEVICE : result;
    }
    return DGB_OK;
}

DGB_API dgb_result dgb_init(dgb_context* context, const dgb_desc* desc) {
    dgb_context c;
    dgb_log_item item;
    dgb_result result;
    if (!context || !desc) return dgbi_fail(desc, DGB_INVALID, DGB_LOG_NULL_ARGUMENT);
    item = dgbi_check_backend(desc->backend);
    if (item != DGB_LOG_NONE) return dgbi_fail(desc, DGB_INVALID, item);
    memset(&c, 0, sizeof c);
    result = dgb_make_plan(desc, &c.plan);
    if (result != DGB_OK) return result;
    c.desc = *desc;
    dgbi_resolve_defaults(&c.desc);
    c.backend = *desc->backend;
    c.desc.backend = NULL; /* the caller's struct need not live on */
    dgbi_begin(&c.backend);
    result = dgbi_create_textures(&c.backend, &c.plan, c.textures);
    if (result != DGB_OK) item = DGB_LOG_TEXTURE;
    if (result == DGB_OK) {
        result = dgbi_create_programs(&c.backend, &c.plan, c.programs);
        if (result != DGB_OK) {
            item = DGB_LOG_PROGRAM;
            dgbi_destroy_textures(&c.backend, c.textures);
        }
    }
    (void)dgbi_end(&c.backend);
    if (result != DGB_OK) return dgbi_fail(desc, result, item);
    c.initialised = DGBI_INITIALISED;
    *context = c;
    return DGB_OK;
}

static bool dgbi_is_live(const dgb_context* context) { return context && context->initialised == DGBI_INITIALISED; }

DGB_API dgb_result dgb_resize(dgb_context* context, int width, int height) {
    dgb_desc desc;
    dgb_plan plan;
    dgb_texture textures[DGB_SLOT_COUNT];
    dgb_result result;
    if (!dgbi_is_live(context)) return DGB_INVALID;
    if (width == context->desc.width && height == context->desc.height) return DGB_OK;
    desc = context->desc;
    desc.backend = &context->backend;
    desc.width = width;
    desc.height = height;
    result = dgb_make_plan(&desc, &plan);
    if (result != DGB_OK) return result;
    dgbi_begin(&context->backend);
    result = dgbi_create_textures(&context->backend, &plan, textures);
    if (result == DGB_OK) dgbi_destroy_textures(&context->backend, context->textures);
    (void)dgbi_end(&context->backend);
    if (result != DGB_OK) return dgbi_fail(&desc, result, DGB_LOG_TEXTURE);
    memcpy(context->textures, textures, sizeof textures);
    context->plan = plan;
    context->desc.width = width;
    context->desc.height = height;
    context->has_layers = false;
    context->has_previous = false;
    context->has_history = false;
    return DGB_OK;
}

DGB_API void dgb_shutdown(dgb_context* context) {
    if (!dgbi_is_live(context)) return;
    dgbi_begin(&context->backend);
    dgbi_destroy_programs(&context->backend, context->programs);
    dgbi_destroy_textures(&context->backend, context->textures);
    (void)dgbi_end(&context->backend);
    memset(context, 0, sizeof *context);
}

DGB_API dgb_texture dgb_get_texture(const dgb_context* context, dgb_slot slot) {
    dgb_texture none = {0};
    return dgbi_is_live(context) && dgbi_in_range((int)slot, 0, DGB_SLOT_COUNT - 1) ? context->textures[slot] : none;
}

/* >> frame: running the plan */

static void dgbi_marker(const dgb_context* c, dgb_pass_id id, bool begin) {
    if (c->backend.marker) c->backend.marker(c->backend.user, id, begin);
}

static void dgbi_begin_drawing(dgb_context* c) {
    c->drawing = DGB_OK;
    dgbi_begin(&c->backend);
}

static dgb_result dgbi_end_drawing(dgb_context* c) {
    const dgb_result unnoticed = dgbi_end(&c->backend);
    if (c->drawing == DGB_OK) c->drawing = unnoticed;
    return c->drawing == DGB_OK ? DGB_OK : dgbi_fail(&c->desc, c->drawing, DGB_LOG_PASS);
}

/* False once the device has refused a pass of this call. */
static bool dgbi_pass_begins(dgb_context* c, const dgb_pass* pass) {
    if (c->drawing == DGB_OK) c->drawing = c->backend.pass_begin(c->backend.user, pass);
    return c->drawing == DGB_OK;
}

/* Whether it writes the level that it is named for, and reads the one before. */
static bool dgbi_writes_level(const dgb_plan_pass* pass) {
    return pass->id == DGB_PASS_MIP || pass->id == DGB_PASS_RANGE;
}

/* Of the passes that draw the scene. */
static bool dgbi_is_depth_only(const dgb_plan_pass* pass) {
    return pass->id == DGB_PASS_BACK || pass->id == DGB_PASS_PREDICT;
}

static bool dgbi_begin_pass(dgb_context* c, const dgb_plan_pass* plan_pass, dgb_pass* pass, int layer) {
    int i;
    pass->id = plan_pass->id;
    pass->color_count = dgbi_is_depth_only(plan_pass) ? 0 : plan_pass->output_count;
    for (i = 0; i < pass->color_count; ++i) {
        pass->colors[i].texture = c->textures[plan_pass->outputs[i]];
        pass->colors[i].level = dgbi_writes_level(plan_pass) ? plan_pass->level : 0;
        pass->colors[i].layer = layer;
    }
    return dgbi_pass_begins(c, pass);
}

static void dgbi_bind_inputs(const dgb_context* c, const dgb_plan_pass* pass) {
    int i;
    for (i = 0; i < pass->input_count; ++i)
        c->backend.texture_bind(c->backend.user, pass->inputs[i].name, c->textures[pass->inputs[i].texture],
                                dgbi_writes_level(pass) ? pass->level - 1 : -1);
}

/* >> frame, layers */

typedef struct dgbi_build {         /* one submission: the layers, the back faces, or the prediction */
    const dgb_plan_pass* plan_pass; /* LAYERS, BACK or PREDICT */
    dgb_slot depth;                 /* depth layers written */
    dgb_slot front;                 /* depth layers that PEEL compares with */
    int layers;
    dgb_pose pose, previous;
    dgb_camera camera;
    dgb_oracle oracle;
    dgb_emission emission;
    int pose_offset; /* dgb_draw.pose */
    float separation;
    dgb_draw_fn draw;
    void* user;
} dgbi_build;

static void dgbi_fill_draw(const dgb_context* c, const dgbi_build* b, dgb_draw* draw) {
    memset(draw, 0, sizeof *draw);
    draw->oracle = b->oracle;
    draw->emission = b->emission;
    draw->pose = b->pose_offset;
    draw->depth_only = dgbi_is_depth_only(b->plan_pass);
    draw->back_faces = b->plan_pass->id == DGB_PASS_BACK;
    draw->width = c->plan.width;
    draw->height = c->plan.height;
    memcpy(draw->view, b->pose.view, sizeof draw->view);
    memcpy(draw->projection, b->pose.projection, sizeof draw->projection);
    memcpy(draw->previous_view, b->previous.view, sizeof draw->view);
    memcpy(draw->previous_projection, b->previous.projection, sizeof draw->projection);
}

static void dgbi_draw_uniforms(const dgb_context* c, const dgbi_build* b, const dgb_draw* draw, dgb_draw_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = b->camera;
    /* peeling reads this frame's depth, and warped depth is as this frame's */
    u->previous = draw->oracle == DGB_ORACLE_PEEL || draw->oracle == DGB_ORACLE_WARP ? b->camera : c->oracle_camera;
    dgbi_distance_row(draw->projection, u->distance);
    dgbi_distance_row(draw->previous_projection, u->previous_distance);
    u->size[0] = (float)draw->width;
    u->size[1] = (float)draw->height;
    u->size[2] = b->separation;
    u->size[3] = dgbi_depth_codes(c->desc.depth_format);
    u->layer[0] = draw->first_layer;
    u->layer[1] = draw->layer_count;
    u->layer[2] = (int32_t)draw->oracle;
    u->layer[3] = draw->instances;
    u->flags[0] = c->desc.divisor;
    u->flags[1] = c->desc.reversed;
}

/* One layered pass: all layers at once, or one. IMAGE emission rasterises the first alone, and stores the others. */
static void dgbi_layer_pass(dgb_context* c, const dgbi_build* b, const dgb_draw* draw) {
    const bool image = draw->emission == DGB_EMISSION_IMAGE && draw->layer_count > 1;
    const int layer = draw->layer_count > 1 && !image ? -1 : draw->first_layer;
    /* no quotient: with -ffast-math a whole width may come out a little less */
    const float deep = c->desc.divisor == 4 ? 0.25f : c->desc.divisor == 2 ? 0.5f : 1.0f;
    const float scale = layer > 0 ? deep : 1.0f;
    dgb_draw_uniforms uniforms;
    dgb_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.depth.texture = c->textures[b->depth];
    pass.depth.layer = draw->back_faces ? 0 : layer; /* they have a texture of their own */
    pass.width = (float)c->plan.width * scale;
    pass.height = (float)c->plan.height * scale;
    pass.deep_width = (float)c->plan.width * deep;
    pass.deep_height = (float)c->plan.height * deep;
    pass.clear = true;
    pass.clear_depth = dgbi_clear_depth(c->desc.reversed);
    pass.reversed = c->desc.reversed;
    pass.clip = c->desc.clip;
    pass.emission = draw->emission;
    if (image) {
        pass.key = c->textures[DGB_KEY];
        pass.key_layers = b->layers - 1;
    }
    if (!dgbi_begin_pass(c, b->plan_pass, &pass, layer)) return;
    if (b->plan_pass->input_count)
        c->backend.texture_bind(c->backend.user, DGB_ORACLE,
                                c->textures[draw->oracle == DGB_ORACLE_PEEL ? b->front : DGB_ORACLE], -1);
    dgbi_draw_uniforms(c, b, draw, &uniforms);
    c->backend.uniforms_upload(c->backend.user, &uniforms, sizeof uniforms);
    b->draw(b->user, draw);
    c->backend.pass_end(c->backend.user);
}

static void dgbi_submit(dgb_context* c, const dgbi_build* b) {
    dgb_draw draw;
    dgbi_marker(c, b->plan_pass->id, true);
    dgbi_fill_draw(c, b, &draw);
    if (b->oracle == DGB_ORACLE_PEEL || b->emission == DGB_EMISSION_SEPARATE || b->layers == 1) {
        draw.layer_count = draw.instances = 1;
        for (draw.first_layer = 0; draw.first_layer < b->layers; ++draw.first_layer) dgbi_layer_pass(c, b, &draw);
    } else {
        draw.layer_count = b->layers;
        draw.instances = b->emission == DGB_EMISSION_VERTEX ? b->layers : 1;
        dgbi_layer_pass(c, b, &draw);
    }
    dgbi_marker(c, b->plan_pass->id, false);
}

static const dgb_plan_pass* dgbi_find_pass(const dgb_plan* plan, dgb_pass_id id) {
    int i;
    for (i = 0; i < plan->pass_count; ++i)
        if (plan->passes[i].id == id) return &plan->passes[i];
    return NULL;
}

/* Writes one layer of depth, so many texels of it, with a full-screen triangle: WARP, RESOLVE. */
static void dgbi_write_depth(dgb_context* c, const dgb_plan_pass* plan_pass, dgb_target target, int width, int height,
                             const void* uniforms, size_t size) {
    dgb_pass pass;
    memset(&pass, 0, sizeof pass);
    pass.id = plan_pass->id;
    pass.depth = target;
    pass.width = (float)width;
    pass.height = (float)height;
    pass.clip = c->desc.clip;
    if (!dgbi_pass_begins(c, &pass)) return;
    dgbi_bind_inputs(c, plan_pass);
    c->backend.uniforms_upload(c->backend.user, uniforms, size);
    c->backend.draw_fullscreen(c->backend.user, c->programs[plan_pass->program]);
    c->backend.pass_end(c->backend.user);
}

/* IMAGE emission: the depth bits of each deeper layer become its depth. Layers that were peeled have it already. */
static void dgbi_resolve(dgb_context* c, const dgbi_build* b) {
    const dgb_plan_pass* plan_pass = dgbi_find_pass(&c->plan, DGB_PASS_RESOLVE);
    dgb_target target = {{0}, 0, 1};
    dgb_resolve_uniforms u;
    if (b->emission != DGB_EMISSION_IMAGE || b->oracle == DGB_ORACLE_PEEL || b->layers == 1) return;
    memset(&u, 0, sizeof u);
    target.texture = c->textures[b->depth];
    dgbi_marker(c, DGB_PASS_RESOLVE, true);
    for (; target.layer < b->layers; ++target.layer) {
        u.layer[0] = target.layer - 1;
        dgbi_write_depth(c, plan_pass, target, c->plan.width, c->plan.height, &u, sizeof u);
    }
    dgbi_marker(c, DGB_PASS_RESOLVE, false);
}

/* BACK_FACES: a peel of nothing but depth, by no separation, of what faces away. layers: as they were drawn */
static void dgbi_back(dgb_context* c, const dgbi_build* layers) {
    dgbi_build b = *layers;
    dgb_draw draw;
    b.plan_pass = dgbi_find_pass(&c->plan, DGB_PASS_BACK);
    if (!b.plan_pass) return;
    b.depth = DGB_BACK;
    b.oracle = DGB_ORACLE_PEEL;
    b.separation = 0.0f;
    dgbi_marker(c, DGB_PASS_BACK, true);
    dgbi_fill_draw(c, &b, &draw);
    draw.first_layer = draw.layer_count = draw.instances = 1;
    dgbi_layer_pass(c, &b, &draw);
    dgbi_marker(c, DGB_PASS_BACK, false);
}

static void dgbi_swap(dgb_context* c, dgb_slot a, dgb_slot b) {
    const dgb_texture texture = c->textures[a];
    c->textures[a] = c->textures[b];
    c->textures[b] = texture;
}

/* Affine matrices in double: columns of three rows, then the translation. */
static void dgbi_affine(const float m[16], double affine[12]) {
    int row, column;
    for (column = 0; column < 4; ++column)
        for (row = 0; row < 3; ++row) affine[column * 3 + row] = (double)m[column * 4 + row];
}

/* False when the matrix is singular. */
static bool dgbi_invert_affine(const float m[16], double inverse[12]) {
    const double a = m[0], b = m[4], c = m[8], d = m[1], e = m[5], f = m[9], g = m[2], h = m[6], i = m[10];
    const double cofactors[9] = {e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g,
                                 c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d};
    const double determinant = a * cofactors[0] + b * cofactors[3] + c * cofactors[6];
    int row, column;
    if (!(determinant > 0.0 || determinant < 0.0)) return false;
    for (row = 0; row < 3; ++row) {
        for (column = 0; column < 3; ++column) inverse[column * 3 + row] = cofactors[row * 3 + column] / determinant;
        inverse[9 + row] = -(inverse[row] * m[12] + inverse[3 + row] * m[13] + inverse[6 + row] * m[14]);
    }
    return true;
}

/* product = m n */
static void dgbi_multiply_affine(const double m[12], const double n[12], double product[12]) {
    int row, column;
    for (column = 0; column < 4; ++column)
        for (row = 0; row < 3; ++row)
            product[column * 3 + row] = m[row] * n[column * 3] + m[3 + row] * n[column * 3 + 1] +
                                        m[6 + row] * n[column * 3 + 2] + (column == 3 ? m[9 + row] : 0.0);
}

/* The view after `now` when it goes on moving as from `before` to `now`: now before^-1 now. */
static void dgbi_extrapolate_view(const float before[16], const float now[16], float next[16]) {
    double inverse[12], affine[12], step[12], result[12];
    int row, column;
    memcpy(next, now, sizeof(float) * 16);
    if (!dgbi_invert_affine(before, inverse)) return;
    dgbi_affine(now, affine);
    dgbi_multiply_affine(affine, inverse, step);
    dgbi_multiply_affine(step, affine, result);
    for (column = 0; column < 4; ++column)
        for (row = 0; row < 3; ++row) next[column * 4 + row] = (float)result[column * 3 + row];
    if (!dgbi_all_finite(next, 16)) memcpy(next, now, sizeof(float) * 16); /* `before` was nearly singular */
}

/* From this frame's camera space to last frame's; exactly the identity for equal views, or if it overflows. */
static void dgbi_to_last(const float now[16], const float last[16], float rows[3][4]) {
    double inverse[12], affine[12], change[12];
    bool valid = !dgbi_same_bits(now, last, 16) && dgbi_invert_affine(now, inverse);
    int row, column, i;
    dgbi_affine(last, affine);
    if (valid) dgbi_multiply_affine(affine, inverse, change);
    for (i = 0; valid && i < 12; ++i) valid = dgbi_is_finite((float)change[i]);
    for (column = 0; column < 4; ++column)
        for (row = 0; row < 3; ++row)
            rows[row][column] = valid ? (float)change[column * 3 + row] : column == row ? 1.0f : 0.0f;
}

/* WARP: last frame's depth of each layer that another is compared with, as this frame's camera sees it. */
static void dgbi_warp(dgb_context* c, const dgbi_build* b) {
    const dgb_plan_pass* plan_pass = dgbi_find_pass(&c->plan, DGB_PASS_WARP);
    const int width = c->plan.width, height = c->plan.height;
    dgb_target target = {{0}, 0, 0};
    dgb_warp_uniforms u;
    if (!plan_pass || b->oracle == DGB_ORACLE_PEEL) return;
    memset(&u, 0, sizeof u);
    target.texture = c->textures[DGB_ORACLE];
    u.camera = b->camera;
    u.last = c->camera;
    u.depth[0] = dgbi_depth_codes(c->desc.depth_format);
    dgbi_to_last(b->pose.view, c->drawn.view, u.to_last);
    dgbi_marker(c, DGB_PASS_WARP, true);
    for (; target.layer < b->layers - 1; ++target.layer) {
        const int divisor = target.layer ? c->desc.divisor : 1;
        u.layer[0] = target.layer;
        u.layer[1] = divisor;
        u.layer[2] = dgbi_units(2 * width - divisor, 2 * divisor) - 1; /* whose centre lies within the buffer */
        u.layer[3] = dgbi_units(2 * height - divisor, 2 * divisor) - 1;
        dgbi_write_depth(c, plan_pass, target, dgbi_units(width, divisor), dgbi_units(height, divisor), &u, sizeof u);
    }
    dgbi_marker(c, DGB_PASS_WARP, false);
}

static void dgbi_submitted_pose(const dgb_context* c, const dgb_view* view, dgb_pose* pose) {
    memcpy(pose->view, view->view, sizeof pose->view);
    dgb_widen_projection(view->projection, c->desc.width, c->desc.height, c->desc.guard_band, view->jitter,
                         pose->projection);
}

/* What the layers are drawn with: the pose submitted, or with DELAY the one before it. */
static void dgbi_main_build(const dgb_context* c, const dgb_pose* submitted, bool fresh, dgbi_build* b) {
    const bool delayed = c->plan.oracle == DGB_ORACLE_DELAY && !fresh;
    b->plan_pass = dgbi_find_pass(&c->plan, DGB_PASS_LAYERS);
    b->depth = b->front = DGB_DEPTH;
    b->layers = c->plan.layers;
    b->pose = delayed ? c->pending : *submitted;
    b->previous = fresh ? b->pose : c->drawn;
    b->oracle = fresh ? DGB_ORACLE_PEEL : c->plan.oracle;
    b->emission = c->plan.emission;
    b->pose_offset = delayed ? -1 : 0;
}

/* What the next frame's oracle is drawn with: with DELAY the pose submitted, with PREDICT a guess. */
static void dgbi_predict_build(const dgb_context* c, const dgb_pose* submitted, const dgb_view* view, bool fresh,
                               dgbi_build* b) {
    b->plan_pass = dgbi_find_pass(&c->plan, DGB_PASS_PREDICT);
    b->depth = b->front = DGB_PREDICTED;
    b->layers = c->plan.layers - 1;
    b->previous = b->pose;
    b->pose = *submitted;
    b->pose_offset = c->plan.oracle == DGB_ORACLE_PREDICT ? 1 : 0;
    if (c->plan.oracle != DGB_ORACLE_PREDICT) return;
    if (view->has_next)
        memcpy(b->pose.view, view->next_view, sizeof b->pose.view);
    else if (!fresh)
        dgbi_extrapolate_view(c->drawn.view, submitted->view, b->pose.view);
}

static dgb_log_item dgbi_check_view(const dgb_view* view, bool reversed) {
    if (!dgbi_all_finite(view->view, 16) || !dgbi_all_finite(view->jitter, 2)) return DGB_LOG_MATRIX;
    if (view->has_next && !dgbi_all_finite(view->next_view, 16)) return DGB_LOG_MATRIX;
    return dgbi_check_projection(view->projection, reversed);
}

static dgb_result dgbi_camera_of(const dgb_context* c, const dgb_pose* pose, dgb_camera* camera) {
    return dgb_camera_from_matrix(pose->projection, c->plan.width, c->plan.height, c->desc.clip, c->desc.reversed,
                                  camera);
}

/* cut: they show another place than the layers before */
static void dgbi_new_layers(dgb_context* c, bool cut) {
    c->has_layers = true;
    c->has_history = c->has_history && !cut;
    ++c->built;
}

DGB_API dgb_result dgb_build(dgb_context* context, const dgb_view* view, const dgb_params* params, dgb_draw_fn draw_fn,
                             void* user) {
    dgb_log_item item = DGB_LOG_NONE;
    dgb_pose submitted;
    dgb_camera camera; /* of the pose submitted */
    dgbi_build b;
    bool fresh, predicts;
    if (!dgbi_is_live(context)) return DGB_INVALID;
    if (!view || !params || !draw_fn) item = DGB_LOG_NULL_ARGUMENT;
    if (item == DGB_LOG_NONE && context->desc.source != DGB_SOURCE_BUILD) item = DGB_LOG_WRONG_SOURCE;
    if (item == DGB_LOG_NONE) item = dgbi_check_view(view, context->desc.reversed);
    if (item == DGB_LOG_NONE) item = dgbi_check_params(params);
    if (item != DGB_LOG_NONE) return dgbi_fail(&context->desc, DGB_INVALID, item);
    dgbi_submitted_pose(context, view, &submitted);
    if (dgbi_camera_of(context, &submitted, &camera)) return dgbi_fail(&context->desc, DGB_INVALID, DGB_LOG_PROJECTION);

    fresh = !context->has_previous || view->cut;
    predicts = context->textures[DGB_PREDICTED].id != 0;
    memset(&b, 0, sizeof b);
    b.separation = params->separation;
    b.draw = draw_fn;
    b.user = user;
    if (predicts)
        dgbi_swap(context, DGB_PREDICTED, DGB_ORACLE);
    else if (context->textures[DGB_ORACLE].id && context->plan.oracle != DGB_ORACLE_WARP)
        dgbi_swap(context, DGB_DEPTH, DGB_ORACLE);
    dgbi_main_build(context, &submitted, fresh, &b);
    b.camera = camera;
    if (b.pose_offset) (void)dgbi_camera_of(context, &b.pose, &b.camera); /* was fine when it was submitted */

    dgbi_begin_drawing(context);
    dgbi_warp(context, &b);
    dgbi_submit(context, &b);
    dgbi_resolve(context, &b);
    dgbi_back(context, &b);
    context->camera = b.camera;
    if (predicts) {
        const dgb_pose drawn = b.pose;
        dgbi_predict_build(context, &submitted, view, fresh, &b);
        b.camera = camera; /* the projection is the submitted one's */
        dgbi_submit(context, &b);
        dgbi_resolve(context, &b);
        b.pose = drawn;
    }
    if (dgbi_end_drawing(context) != DGB_OK) {
        context->has_layers = context->has_previous = context->has_history = false;
        return context->drawing;
    }

    context->oracle_camera = b.camera;
    context->drawn = b.pose;
    context->pending = submitted;
    context->has_previous = true;
    dgbi_new_layers(context, fresh);
    return DGB_OK;
}

/* Textures go into the slots that the plan's passes read. */
static bool dgbi_take_layers(const dgb_plan* plan, const dgb_layers* layers, dgb_texture textures[DGB_SLOT_COUNT]) {
    int i, j;
    if (!plan->pass_count) return true;
    textures[DGB_ENGINE_DEPTH0] = layers->depth[0];
    textures[DGB_ENGINE_DEPTH1] = layers->depth[1];
    textures[DGB_ENGINE_NORMAL0] = layers->normal[0];
    textures[DGB_ENGINE_NORMAL1] = layers->normal[1];
    textures[DGB_ENGINE_RADIANCE0] = layers->radiance[0];
    textures[DGB_ENGINE_RADIANCE1] = layers->radiance[1];
    textures[DGB_ENGINE_ALBEDO0] = layers->albedo[0];
    textures[DGB_ENGINE_ALBEDO1] = layers->albedo[1];
    textures[DGB_ENGINE_VELOCITY0] = layers->velocity[0];
    textures[DGB_ENGINE_VELOCITY1] = layers->velocity[1];
    textures[DGB_ENGINE_BACK] = layers->back;
    textures[DGB_ENGINE_ROUGHNESS] = layers->roughness;
    for (i = 0; i < plan->pass_count; ++i)
        for (j = 0; j < plan->passes[i].input_count; ++j)
            if (!textures[plan->passes[i].inputs[j].texture].id) return false;
    return true;
}

DGB_API dgb_result dgb_set_layers(dgb_context* context, const dgb_view* view, const dgb_layers* layers) {
    dgb_log_item item = DGB_LOG_NONE;
    dgb_texture textures[DGB_SLOT_COUNT];
    dgb_pose pose;
    dgb_camera camera;
    if (!dgbi_is_live(context)) return DGB_INVALID;
    if (!view || !layers) item = DGB_LOG_NULL_ARGUMENT;
    if (item == DGB_LOG_NONE && context->desc.source != DGB_SOURCE_ENGINE) item = DGB_LOG_WRONG_SOURCE;
    if (item == DGB_LOG_NONE) item = dgbi_check_view(view, context->desc.reversed);
    memcpy(textures, context->textures, sizeof textures);
    if (item == DGB_LOG_NONE && !dgbi_take_layers(&context->plan, layers, textures)) item = DGB_LOG_INPUT;
    if (item != DGB_LOG_NONE) return dgbi_fail(&context->desc, DGB_INVALID, item);
    dgbi_submitted_pose(context, view, &pose);
    if (dgbi_camera_of(context, &pose, &camera)) return dgbi_fail(&context->desc, DGB_INVALID, DGB_LOG_PROJECTION);
    memcpy(context->textures, textures, sizeof textures);
    context->drawn = pose;
    context->camera = camera;
    dgbi_new_layers(context, view->cut);
    return DGB_OK;
}

/* >> frame, shading: one function a pass fills its uniforms */

/* The part of the buffer that is shaded: the image plus guard_fraction of the guard band. x, y, width, height. */
static void dgbi_shaded_rect(const dgb_context* c, const dgb_params* q, int rect[4]) {
    const int inset = c->desc.guard_band - (int)((float)c->desc.guard_band * q->guard_fraction + 0.5f);
    rect[0] = rect[1] = inset;
    rect[2] = c->plan.width - 2 * inset;
    rect[3] = c->plan.height - 2 * inset;
}

/* The image, for nothing reads reflections in the guard band. x, y, width, height. */
static void dgbi_image_rect(const dgb_context* c, int rect[4]) {
    rect[0] = rect[1] = c->desc.guard_band;
    rect[2] = c->desc.width;
    rect[3] = c->desc.height;
}

/* As shaders have it: x0, y0, x1, y1, the last two inclusive. */
static void dgbi_inclusive(const int rect[4], int32_t inclusive[4]) {
    inclusive[0] = rect[0];
    inclusive[1] = rect[1];
    inclusive[2] = rect[0] + rect[2] - 1;
    inclusive[3] = rect[1] + rect[3] - 1;
}

static void dgbi_fill_rect(const dgb_context* c, const dgb_params* q, int32_t inclusive[4]) {
    int rect[4];
    dgbi_shaded_rect(c, q, rect);
    dgbi_inclusive(rect, inclusive);
}

/* usable: whether last frame is worth looking at. Layers that are shaded again have not moved. */
static void dgbi_fill_reprojection(const dgb_context* c, const dgb_params* q, bool usable, dgb_reprojection* r) {
    const bool again = c->built == c->shaded;
    r->last = usable ? c->shaded_camera : c->camera;
    dgbi_to_last(c->drawn.view, usable ? c->shaded_pose.view : c->drawn.view, r->to_last);
    r->tolerance[0] = q->history_tolerance;
    r->tolerance[1] = q->history_floor;
    r->tolerance[2] = usable ? 1.0f : 0.0f;
    r->tolerance[3] = again ? 0.0f : 1.0f;
    dgbi_fill_rect(c, usable ? &c->shaded_params : q, r->rect);
}

/* Whether what is computed is the same; parameters that only change how well are left out. */
static bool dgbi_same_result(const dgb_params* a, const dgb_params* b) {
    const float x[] = {a->separation,   a->ao_radius, a->ao_bias,  a->ao_epsilon,
                       a->ao_intensity, a->radius,    a->thickness},
                y[] = {b->separation,   b->ao_radius, b->ao_bias,  b->ao_epsilon,
                       b->ao_intensity, b->radius,    b->thickness};
    return dgbi_same_bits(x, y, 7) && a->strict_separation == b->strict_separation &&
           a->second_alone == b->second_alone;
}

/* The same of reflections. */
static bool dgbi_same_reflection(const dgb_params* a, const dgb_params* b) {
    const float x[] = {a->separation, a->reflect_distance, a->reflect_thickness},
                y[] = {b->separation, b->reflect_distance, b->reflect_thickness};
    return dgbi_same_bits(x, y, 3) && a->strict_separation == b->strict_separation;
}

static void dgbi_pack_uniforms(const dgb_context* c, const dgb_params* q, dgb_pack_uniforms* u) {
    int column, row;
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    for (column = 0; column < 3; ++column)
        for (row = 0; row < 3; ++row)
            u->rotation[column][row] = c->desc.world_normals ? c->drawn.view[column * 4 + row]
                                       : column == row       ? 1.0f
                                                             : 0.0f;
    u->separation[0] = q->strict_separation ? q->separation : -1.0f;
    u->separation[1] = dgbi_depth_codes(c->desc.depth_format);
    u->size[0] = c->plan.width;
    u->size[1] = c->plan.height;
    u->bounce[0] = q->bounce_damping;
    u->bounce[1] = q->boost_unsaturated;
    u->bounce[2] = q->boost_saturated;
    u->bounce[3] = (float)q->samples;
    dgbi_fill_reprojection(c, q, c->has_history, &u->past);
}

static void dgbi_fill_taps(int count, float taps[][4]) {
    int i;
    for (i = 0; i < count; ++i) dgb_spiral_tap(i, count, taps[i]);
}

/* Every frame takes other taps where they are averaged, and always the same where they are not. */
static void dgbi_fill_size(const dgb_context* c, const dgb_params* q, int taps, int32_t size[4]) {
    const bool averaged = (c->desc.effects & DGB_EFFECT_TEMPORAL) && q->history_weight > 0.0f;
    size[0] = c->plan.width;
    size[1] = c->plan.height;
    size[2] = taps;
    size[3] = averaged ? (int32_t)(c->frame & 0xffffffu) : 0;
}

static void dgbi_fill_level(const dgb_context* c, const dgb_params* q, int log2_q, int min_level, int32_t level[4]) {
    level[0] = log2_q;
    level[1] = dgbi_min(min_level, c->plan.levels - 1);
    level[2] = c->plan.levels - 1;
    level[3] = !q->adaptive;
}

/* No tap is farther than the buffer's diagonal: beyond, every tap would land on the border. */
static float dgbi_max_reach(const dgb_context* c) {
    return sqrtf((float)c->plan.width * (float)c->plan.width + (float)c->plan.height * (float)c->plan.height);
}

/* For the bitmask a surface matters as far away as its object reaches behind it. */
static void dgbi_tiles_uniforms(const dgb_context* c, const dgb_params* q, dgb_tiles_uniforms* u) {
    const float behind = c->desc.estimator == DGB_ESTIMATOR_BITMASK ? q->thickness : 0.0f;
    const int least = q->ao_min_level > q->min_level ? q->ao_min_level : q->min_level;
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    u->radius[0] = q->ao_radius + behind;
    u->radius[1] = q->radius + behind;
    u->radius[2] = dgbi_max_reach(c);
    u->radius[3] = (float)(1 << least);
}

static void dgbi_ao_uniforms(const dgb_context* c, const dgb_params* q, dgb_ao_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    dgbi_fill_size(c, q, q->ao_samples, u->size);
    dgbi_fill_level(c, q, DGB_AO_LOG2_Q, q->ao_min_level, u->level);
    u->radius[0] = q->ao_radius;
    u->radius[1] = 1.0f / (q->ao_radius * q->ao_radius);
    u->radius[2] = q->ao_bias * q->ao_radius;
    u->radius[3] = (q->ao_epsilon > 1e-12f ? q->ao_epsilon : 1e-12f) * (q->ao_radius * q->ao_radius); /* never 0 / 0 */
    u->scale[0] = (float)(DGBI_PI / q->ao_samples);
    u->scale[1] = q->ao_intensity;
    u->scale[2] = dgbi_max_reach(c);
    u->scale[3] = q->second_alone ? 0.0f : 1.0f;
    dgbi_fill_taps(q->ao_samples, u->taps);
}

static void dgbi_gather_uniforms(const dgb_context* c, const dgb_params* q, dgb_gather_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    dgbi_fill_size(c, q, q->samples, u->size);
    dgbi_fill_level(c, q, DGB_GATHER_LOG2_Q, q->min_level, u->level);
    u->radius[0] = q->radius;
    u->radius[1] = q->radius * q->radius;
    u->radius[2] = c->desc.normaliser == DGB_NORMALISER_BOUNDED ? 1.0f : 0.0f;
    u->radius[3] = dgbi_max_reach(c);
    u->first[0] = q->second_alone ? 0.0f : 1.0f;
    dgbi_fill_taps(q->samples, u->taps);
}

/* Taps are shared among the slices, evenly to both sides; a slice has one to each at least. */
static void dgbi_bitmask_uniforms(const dgb_context* c, const dgb_params* q, bool light, dgb_bitmask_uniforms* u) {
    const int steps = (light ? q->samples : q->ao_samples) / (2 * q->slices);
    const float radius = light ? q->radius : q->ao_radius;
    int column, row;
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    dgbi_fill_size(c, q, steps > 1 ? steps : 1, u->size);
    dgbi_fill_level(c, q, light ? DGB_GATHER_LOG2_Q : DGB_AO_LOG2_Q, light ? q->min_level : q->ao_min_level, u->level);
    u->radius[0] = radius;
    u->radius[1] = radius * radius;
    u->radius[2] = q->thickness;
    u->radius[3] = dgbi_max_reach(c);
    u->scale[0] = (float)q->slices;
    u->scale[1] = 1.0f / (float)q->slices;
    u->scale[2] = q->ao_intensity;
    u->scale[3] = q->second_alone ? 0.0f : 1.0f;
    for (column = 0; column < 3; ++column)
        for (row = 0; row < 3; ++row) u->world[column][row] = c->drawn.view[row * 4 + column]; /* turned back */
}

static void dgbi_temporal_uniforms(const dgb_context* c, const dgb_params* q, dgb_temporal_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    u->weight[0] = q->history_weight;
    u->weight[1] = q->history_clamp;
    u->weight[2] = q->sample_clamp;
    u->weight[3] = (float)(c->frame & 0xffffffu);
    dgbi_fill_rect(c, q, u->rect);
    dgbi_fill_reprojection(c, q, c->has_history && dgbi_same_result(q, &c->shaded_params), &u->past);
}

/* Gaussian whose standard deviation is half the radius. The sum does not matter: the shader divides by it. */
static void dgbi_filter_weights(int radius, float weights[][4]) {
    const double sigma = radius > 0 ? 0.5 * radius : 1.0;
    int i;
    for (i = 0; i <= radius; ++i) weights[i][0] = (float)exp(-0.5 * i * i / (sigma * sigma));
}

static void dgbi_reconstruct_uniforms(const dgb_context* c, const dgb_params* q, int axis,
                                      dgb_reconstruct_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    dgbi_fill_rect(c, q, u->rect);
    u->axis[0] = axis == 0 ? q->filter_step : 0;
    u->axis[1] = axis == 1 ? q->filter_step : 0;
    u->axis[2] = q->filter_taps / 2;
    u->sharpness[0] = q->normal_sharpness;
    u->sharpness[1] = q->plane_sharpness;
    dgbi_filter_weights(q->filter_taps / 2, u->weights);
}

/* Exponent of the least power of two that is no less. */
static int dgbi_log2_ceil(int x) {
    int exponent = 0;
    while (1 << exponent < x) ++exponent;
    return exponent;
}

static void dgbi_reflect_uniforms(const dgb_context* c, const dgb_params* q, dgb_reflect_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    dgbi_fill_size(c, q, q->reflect_steps, u->size);
    dgbi_fill_rect(c, q, u->rect);
    u->ray[0] = q->reflect_distance;
    u->ray[1] = q->reflect_thickness;
    u->ray[2] = (float)q->reflect_stride;
    u->ray[3] = dgb_linear_z(1.0f - dgbi_clear_depth(c->desc.reversed), &c->camera);
    u->fade[0] = q->reflect_border;
    u->skip[1] = dgbi_log2_ceil(q->reflect_stride);
    u->skip[0] =
        dgbi_log2_ceil(DGB_CELL_SIZE) + dgbi_range_levels(&c->plan) - 1 - u->skip[1]; /* of the coarsest cell */
}

static void dgbi_glossy_uniforms(const dgb_context* c, const dgb_params* q, dgb_glossy_uniforms* u) {
    const bool usable = c->has_history && dgbi_same_reflection(q, &c->shaded_params);
    int32_t size[4];
    int rect[4];
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    dgbi_image_rect(c, rect);
    dgbi_inclusive(rect, u->rect);
    dgbi_fill_size(c, q, q->glossy_taps, size);
    u->size[0] = q->glossy_taps;
    u->size[1] = size[3];
    u->reach[0] = q->glossy_radius;
    u->reach[1] = q->reflect_distance;
    u->reach[2] = q->history_weight;
    u->sharpness[0] = q->normal_sharpness;
    u->sharpness[1] = q->plane_sharpness;
    dgbi_fill_reprojection(c, q, usable, &u->past);
    memcpy(u->past.rect, u->rect, sizeof u->rect);
    dgbi_fill_taps(q->glossy_taps, u->taps);
}

static void dgbi_upload_uniforms(const dgb_context* c, const dgb_plan_pass* pass, const dgb_params* q) {
    union {
        dgb_pack_uniforms pack;
        dgb_tiles_uniforms tiles;
        dgb_ao_uniforms ao;
        dgb_gather_uniforms gather;
        dgb_bitmask_uniforms bitmask;
        dgb_temporal_uniforms temporal;
        dgb_reconstruct_uniforms reconstruct;
        dgb_reflect_uniforms reflect;
        dgb_glossy_uniforms glossy;
    } u;
    const bool bitmask = c->desc.estimator == DGB_ESTIMATOR_BITMASK;
    size_t size = 0;
    switch (pass->id) {
    case DGB_PASS_PACK: dgbi_pack_uniforms(c, q, &u.pack), size = sizeof u.pack; break;
    case DGB_PASS_TILES:
        if (pass->level < 2) return; /* they only look for extremes */
        dgbi_tiles_uniforms(c, q, &u.tiles), size = sizeof u.tiles;
        break;
    case DGB_PASS_AO:
        if (bitmask) dgbi_bitmask_uniforms(c, q, false, &u.bitmask), size = sizeof u.bitmask;
        if (!bitmask) dgbi_ao_uniforms(c, q, &u.ao), size = sizeof u.ao;
        break;
    case DGB_PASS_GATHER:
        if (bitmask) dgbi_bitmask_uniforms(c, q, true, &u.bitmask), size = sizeof u.bitmask;
        if (!bitmask) dgbi_gather_uniforms(c, q, &u.gather), size = sizeof u.gather;
        break;
    case DGB_PASS_TEMPORAL: dgbi_temporal_uniforms(c, q, &u.temporal), size = sizeof u.temporal; break;
    case DGB_PASS_RECONSTRUCT:
        dgbi_reconstruct_uniforms(c, q, pass->level, &u.reconstruct), size = sizeof u.reconstruct;
        break;
    case DGB_PASS_REFLECT: dgbi_reflect_uniforms(c, q, &u.reflect), size = sizeof u.reflect; break;
    case DGB_PASS_GLOSSY: dgbi_glossy_uniforms(c, q, &u.glossy), size = sizeof u.glossy; break;
    case DGB_PASS_WARP:
    case DGB_PASS_LAYERS:
    case DGB_PASS_RESOLVE:
    case DGB_PASS_BACK:
    case DGB_PASS_PREDICT:
    case DGB_PASS_MIP: /* copies: nothing to tell */
    case DGB_PASS_RANGE:
    case DGB_PASS_COUNT: return;
    }
    c->backend.uniforms_upload(c->backend.user, &u, size);
}

static void dgbi_fullscreen_rect(const dgb_context* c, const dgb_plan_pass* pass, const dgb_params* q, int rect[4]) {
    const int level = pass->id == DGB_PASS_MIP ? pass->level : 0;
    if (pass->id == DGB_PASS_PACK || pass->id == DGB_PASS_MIP) {
        rect[0] = rect[1] = 0;
        rect[2] = c->plan.width >> level;
        rect[3] = c->plan.height >> level;
    } else if (pass->id == DGB_PASS_TILES || pass->id == DGB_PASS_RANGE) {
        rect[0] = rect[1] = 0;
        dgbi_texture_size(&c->plan, pass->outputs[0], rect + 2);
        if (pass->id == DGB_PASS_RANGE) rect[2] >>= pass->level, rect[3] >>= pass->level;
    } else if (pass->id == DGB_PASS_REFLECT || pass->id == DGB_PASS_GLOSSY) {
        dgbi_image_rect(c, rect);
    } else {
        dgbi_shaded_rect(c, q, rect);
    }
}

/* Which of a pass's programs runs. */
static int dgbi_variant(const dgb_plan_pass* pass, const dgb_params* q) {
    if (pass->id == DGB_PASS_GATHER) return q->normal_test;
    if (pass->id == DGB_PASS_TEMPORAL) return q->history_clamp > 0.0f || q->sample_clamp > 0.0f;
    return 0;
}

static void dgbi_run_fullscreen(dgb_context* c, const dgb_plan_pass* plan_pass, const dgb_params* q) {
    const int variant = dgbi_variant(plan_pass, q);
    int rect[4];
    dgb_pass pass;
    memset(&pass, 0, sizeof pass);
    dgbi_fullscreen_rect(c, plan_pass, q, rect);
    pass.x = rect[0];
    pass.y = rect[1];
    pass.width = (float)rect[2];
    pass.height = (float)rect[3];
    if (!dgbi_begin_pass(c, plan_pass, &pass, 0)) return;
    dgbi_bind_inputs(c, plan_pass);
    dgbi_upload_uniforms(c, plan_pass, q);
    c->backend.draw_fullscreen(c->backend.user, c->programs[plan_pass->program + variant]);
    c->backend.pass_end(c->backend.user);
}

/* This frame is last frame from now on. */
static void dgbi_remember(dgb_context* c, const dgb_params* q) {
    c->has_history = true;
    c->shaded = c->built;
    c->shaded_params = *q;
    c->shaded_pose = c->drawn;
    c->shaded_camera = c->camera;
    ++c->frame;
}

DGB_API dgb_result dgb_shade(dgb_context* context, const dgb_params* params) {
    static const dgb_slot turns[][2] = {{DGB_Z, DGB_LAST_Z}, /* present and past */
                                        {DGB_FRAMES, DGB_LAST_FRAMES},
                                        {DGB_BENT_MEAN, DGB_LAST_BENT},
                                        {DGB_IRRADIANCE_MEAN, DGB_LAST_IRRADIANCE},
                                        {DGB_IRRADIANCE1_MEAN, DGB_LAST_IRRADIANCE1},
                                        {DGB_REFLECTION, DGB_LAST_REFLECTION},
                                        {DGB_REFLECTION_FRAMES, DGB_LAST_REFLECTION_FRAMES}};
    dgb_log_item item = DGB_LOG_NONE;
    int i;
    if (!dgbi_is_live(context)) return DGB_INVALID;
    if (!params) item = DGB_LOG_NULL_ARGUMENT;
    if (item == DGB_LOG_NONE && !context->has_layers) item = DGB_LOG_NO_LAYERS;
    if (item == DGB_LOG_NONE) item = dgbi_check_params(params);
    if (item != DGB_LOG_NONE) return dgbi_fail(&context->desc, DGB_INVALID, item);
    if (context->built - context->shaded > 1u) context->has_history = false; /* velocities reach back one frame only */
    for (i = 0; i < DGBI_COUNT(turns); ++i)
        if (context->textures[turns[i][1]].id) dgbi_swap(context, turns[i][0], turns[i][1]);
    dgbi_begin_drawing(context);
    for (i = 0; i < context->plan.pass_count; ++i) {
        const dgb_plan_pass* pass = &context->plan.passes[i];
        if (pass->id <= DGB_PASS_PREDICT) continue; /* dgb_build has run these */
        if (pass->id == DGB_PASS_TILES && !params->adaptive) continue;
        if (i == 0 || pass[-1].id != pass->id) dgbi_marker(context, pass->id, true);
        dgbi_run_fullscreen(context, pass, params);
        if (i + 1 == context->plan.pass_count || pass[1].id != pass->id) dgbi_marker(context, pass->id, false);
    }
    if (dgbi_end_drawing(context) != DGB_OK) {
        context->has_history = false;
        return context->drawing;
    }
    dgbi_remember(context, params);
    return DGB_OK;
}

#ifdef __cplusplus
}
#endif

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#endif /* DEEPGBUFFER_IMPLEMENTATION */
