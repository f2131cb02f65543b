/* The full-screen passes once more, in double precision and a pixel at a time: what the shaders' output is
   compared with. Runs on a packed G-buffer read back from the device. Written from the equations (paper,
   Equations 1, 2, 4, 5; the comments of deepgbuffer.h), not from the shaders. Only the placement of the taps
   is float arithmetic, so that they land on the same texels. Every result comes with the error that float
   arithmetic may have made on the way. */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "deepgbuffer.h"

#define REFERENCE_EPSILON 5.9604644775390625e-8 /* half an ulp of a float in 1..2: the unit of every error */

typedef struct reference { /* the packed shading input */
    int width, height, layers, levels;
    int divisor;                        /* of layer 1's resolution */
    float* z[DGB_MAX_LEVELS];           /* `layers` a texel */
    float* normals[DGB_MAX_LEVELS];     /* 2 * layers a texel: bytes over 255 */
    float* radiance[2][DGB_MAX_LEVELS]; /* 3 a texel; null: none */
    double projection[16];              /* widened and jittered */
    dgb_camera camera;                  /* for tap placement only */
    int frame;                          /* that the taps are turned for; 0 where frames are not averaged */
} reference;

/* Copies level 0 (radiance[l] may be null) and makes the other levels by the copy rule. */
void reference_open(reference* r, const dgb_context* context, const float* z, const float* normals,
                    const float* const radiance[2]);
void reference_close(reference* r);

/* Width or height of a level. */
int reference_size(int size, int level);

typedef struct reference_ao {
    double sum, error; /* of the taps' terms, and what floats may be off */
    double reach;      /* pixels */
    bool empty;        /* no surface */
} reference_ao;

reference_ao reference_occlusion(const reference* r, const dgb_params* q, int x, int y);
/* Ambient visibility for a sum of terms. */
double reference_visibility(const reference_ao* ao, const dgb_params* q, double sum);

typedef struct reference_light {
    double low[3], high[3]; /* irradiance */
    double low_confidence, high_confidence;
    int doubtful; /* senders so close to the receiver's plane that rounding decides whether they count */
    bool unsure;  /* rounding decides about a sender that matters: no telling */
} reference_light;

/* Of the surface in a layer; both layers take the taps of the first. */
reference_light reference_irradiance(const reference* r, const dgb_params* q, dgb_senders senders,
                                     dgb_normaliser normaliser, int layer, int x, int y);

typedef struct reference_last { /* last frame, for this frame's passes */
    bool usable;                /* it shows the same place */
    bool still;                 /* these layers were shaded last frame already: nothing has moved since */
    int rect[4];                /* shaded then: x0, y0, x1, y1, inclusive */
    double to_last[12];         /* from this frame's camera space to last frame's: columns of three */
    double projection[16];      /* widened and jittered, of last frame */
    const float* z;             /* like reference.z[0] */
    const float* light[2];      /* irradiance and confidence of both layers: 4 a texel */
    const float* frames;        /* DGB_FRAMES: 4 a texel */
    const float* velocity[2];   /* this frame's, of both layers, at each pixel: 3 a pixel */
} reference_last;

/* to_last from two views, both affine. */
void reference_set_views(reference_last* last, const float now[16], const float then[16]);

typedef struct reference_sent {
    double low[3], high[3]; /* radiance */
    bool bounced;           /* light of last frame is in it */
    bool unsure;            /* rounding decides whether last frame shows the surface */
} reference_sent;

/* What the surface in a layer sends: its own radiance and, unless last is null, what fell on it last frame. */
reference_sent reference_radiance(const reference* r, const reference_last* last, const dgb_params* q, int layer,
                                  const float radiance[3], const float albedo[3], int x, int y);

typedef struct reference_mean {
    double value[4], error[4];   /* irradiance and confidence */
    double frames, frames_error; /* that are in it */
    double visibility, visibility_error, visibility_frames, visibility_frames_error;
    double own;       /* pixels that the object itself moved across, by its velocity */
    int texels;       /* of last frame that show the surface */
    bool from_second; /* one of them does in the second layer */
    bool unsure;      /* rounding decides whether last frame shows the surface */
} reference_mean;

/* The average of last frame's average and this frame's light and visibility. */
reference_mean reference_average(const reference* r, const reference_last* last, const dgb_params* q, int layer,
                                 const float light[4], float visibility, int x, int y);

typedef struct reference_filtered {
    double value[4], error[4];
} reference_filtered;

/* One direction (axis 0: along x) of the reconstruction of an image of `channels` floats a texel, along the surfaces of a
   layer; only texels inside rect (x0, y0, x1, y1, inclusive) count. */
reference_filtered reference_reconstruct(const reference* r, const dgb_params* q, int axis, int layer,
                                         const int rect[4], const float* image, int channels, int x, int y);

#endif
