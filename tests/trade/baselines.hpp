// Ambient occlusion as engines have it today, of one layer, to compare with: the library's own pass with another shader, so that
// inputs, taps, MIP levels, radius, filter and reconstruction are the same.
//     sao    obscurance as in Scalable Ambient Obscurance (McGuire, Mara, Luebke 2012): over the spiral, with its falloff
//     gtao   horizons as in Practical Real-Time Strategies for Accurate Indirect Occlusion (Jimenez et al. 2016): slices through
//            the projected normal, cosine-weighted, the cosine of a horizon fading towards the radius
// The third that engines have, the bitmask of one layer with a constant thickness, is the library's own with one layer.
#pragma once

#include "deepgbuffer_gl.h"

enum class Baseline { none, sao, gtao };

const char* name_of(Baseline baseline);

// headless_get_proc, of a GL that compiles the baseline's shader in place of the paper's; none: in place of nothing.
dgbgl_get_proc_fn get_proc_of(Baseline baseline);
