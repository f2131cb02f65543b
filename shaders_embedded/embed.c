/* Writes the GLSL sources into deepgbuffer_gl.h, between two marker lines, as arrays of string literals.

       embed [--check] HEADER NN_NAME.glsl...

   NN_NAME.glsl becomes

       static const char* const dgbgli_glsl_NAME[] = { "...", "...", 0 };

   Every literal holds whole lines and stays below the 4095 characters that C99 promises. The first line is a `#line`
   directive: line L of file NN is reported by drivers as 10000 * NN + L. Trailing white space is dropped.
   With --check nothing is written: the exit status is 1 when the header differs from what would be written. */

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BEGIN_MARKER                                                                    \
    "/* >> embedded GLSL: written by shaders_embedded/embed.c from shaders_embedded/; " \
    "run \"make embed\" */\n"
#define END_MARKER "/* << embedded GLSL */\n"

enum { MAX_LITERAL = 4000, LINES_PER_FILE = 10000 };

#define FAIL(...)                     \
    do {                              \
        fprintf(stderr, __VA_ARGS__); \
        fputc('\n', stderr);          \
        exit(1);                      \
    } while (0)

/* >> a string that grows */

typedef struct text {
    char* data; /* always ends with a 0 */
    size_t size, capacity;
} text;

static void append_bytes(text* t, const char* bytes, size_t size) {
    if (!t->data || t->size + size + 1 > t->capacity) {
        t->capacity = 2 * (t->size + size + 1);
        t->data = realloc(t->data, t->capacity);
        if (!t->data) { FAIL("out of memory"); }
    }
    memcpy(t->data + t->size, bytes, size);
    t->size += size;
    t->data[t->size] = 0;
}

static void append(text* t, const char* string) { append_bytes(t, string, strlen(string)); }

static text read_file(const char* path) {
    FILE* file = fopen(path, "rb");
    if (!file) { FAIL("%s: cannot read", path); }
    text t = {0};
    append(&t, "");
    char buffer[4096];
    size_t size;
    while ((size = fread(buffer, 1, sizeof buffer, file)) > 0) { append_bytes(&t, buffer, size); }
    if (ferror(file)) { FAIL("%s: cannot read", path); }
    fclose(file);
    return t;
}

static void write_file(const char* path, const text* t) {
    text temporary = {0};
    append(&temporary, path);
    append(&temporary, ".new");
    FILE* file = fopen(temporary.data, "wb");
    if (!file) { FAIL("%s: cannot write", temporary.data); }
    size_t written = fwrite(t->data, 1, t->size, file);
    if (fclose(file) != 0 || written != t->size) { FAIL("%s: cannot write", temporary.data); }
    if (rename(temporary.data, path) != 0) { FAIL("%s: cannot replace", path); }
    free(temporary.data);
}

/* >> one shader file */

typedef struct shader_name {
    int number;       /* the NN of NN_NAME.glsl */
    char name[64];    /* the NAME */
    const char* file; /* the path without its folders */
} shader_name;

static shader_name parse_name(const char* path) {
    shader_name s = {0, "", path};
    const char* slash = strrchr(path, '/');
    if (slash) { s.file = slash + 1; }
    int end = 0;
    if (sscanf(s.file, "%4d_%63[a-z0-9_].glsl%n", &s.number, s.name, &end) != 2 || end == 0 || s.file[end]) {
        FAIL("%s: the name is not like 20_pack.glsl", path);
    }
    return s;
}

static int starts_with(const char* line, size_t size, const char* word) {
    return size >= strlen(word) && memcmp(line, word, strlen(word)) == 0;
}

static void check_line(const char* path, int number, const char* line, size_t size) {
    for (size_t i = 0; i < size; i++) {
        if (line[i] == '\t') { FAIL("%s:%d: a tab; use spaces", path, number); }
        if (line[i] < ' ' || line[i] > '~') { FAIL("%s:%d: not printable ASCII", path, number); }
    }
    if (size > MAX_LITERAL) { FAIL("%s:%d: longer than %d characters", path, number, MAX_LITERAL); }
    if (number >= LINES_PER_FILE) { FAIL("%s:%d: too many lines", path, number); }

    size_t i = 0;
    while (i < size && line[i] == ' ') { i++; }
    if (i == size || line[i] != '#') { return; }
    for (i++; i < size && line[i] == ' '; i++) {}
    if (starts_with(line + i, size - i, "version")) { FAIL("%s:%d: #version belongs to the backend", path, number); }
    if (starts_with(line + i, size - i, "include")) { FAIL("%s:%d: GLSL has no #include", path, number); }
}

/* Appends one source line as one literal; `??` would be the beginning of a C trigraph. */
static void append_literal(text* out, const char* line, size_t size) {
    append(out, "    \"");
    for (size_t i = 0; i < size; i++) {
        int trigraph = i > 0 && line[i] == '?' && line[i - 1] == '?';
        if (line[i] == '"' || line[i] == '\\' || trigraph) { append(out, "\\"); }
        append_bytes(out, line + i, 1);
    }
    append(out, "\\n\"");
}

static void embed_shader(text* out, const char* path) {
    shader_name shader = parse_name(path);
    text source = read_file(path);
    if (strlen(source.data) != source.size) { FAIL("%s: holds a 0 byte", path); }

    char line_directive[32];
    sprintf(line_directive, "#line %d", LINES_PER_FILE * shader.number + 1);
    append(out, "static const char* const dgbgli_glsl_");
    append(out, shader.name);
    append(out, "[] = { /* ");
    append(out, shader.file);
    append(out, " */\n");
    append_literal(out, line_directive, strlen(line_directive));

    size_t literal_size = strlen(line_directive) + 1;
    int number = 1;
    for (const char* line = source.data; *line; number++) {
        size_t length = strcspn(line, "\n"), size = length;
        while (size > 0 && isspace((unsigned char)line[size - 1])) { size--; }
        check_line(path, number, line, size);

        int full = literal_size + size + 1 > MAX_LITERAL;
        append(out, full ? ",\n" : "\n");
        literal_size = full ? 0 : literal_size;
        append_literal(out, line, size);
        literal_size += size + 1;

        line += length;
        if (*line == '\n') { line++; }
    }
    append(out, ",\n    0\n};\n");
    free(source.data);
}

/* >> the header */

/* The one place where the marker stands on a line of its own. */
static const char* find_marker(const char* path, const text* header, const char* marker) {
    const char* found = strstr(header->data, marker);
    if (!found || (found != header->data && found[-1] != '\n')) { FAIL("%s: no line %s", path, marker); }
    if (strstr(found + 1, marker)) { FAIL("%s: more than one line %s", path, marker); }
    return found;
}

static text embed_all(const char* path, const text* header, int count, char** shaders) {
    const char* begin = find_marker(path, header, BEGIN_MARKER) + strlen(BEGIN_MARKER);
    const char* end = find_marker(path, header, END_MARKER);
    if (end < begin) { FAIL("%s: the markers are in the wrong order", path); }

    text out = {0};
    append_bytes(&out, header->data, (size_t)(begin - header->data));
    append(&out, "/* clang-format off */\n");
    for (int i = 0; i < count; i++) {
        if (i > 0 && parse_name(shaders[i]).number <= parse_name(shaders[i - 1]).number) {
            FAIL("%s: its number must be above that of %s", shaders[i], shaders[i - 1]);
        }
        append(&out, "\n");
        embed_shader(&out, shaders[i]);
    }
    append(&out, "\n/* clang-format on */\n");
    append(&out, end);
    return out;
}

static void report_difference(const char* path, const text* is, const text* should_be) {
    const char *a = is->data, *b = should_be->data;
    int line = 1;
    for (size_t i = 0; is->data[i] && is->data[i] == should_be->data[i]; i++) {
        if (is->data[i] == '\n') {
            a = is->data + i + 1;
            b = should_be->data + i + 1;
            line++;
        }
    }
    fprintf(stderr, "%s differs from shaders_embedded/: run `make embed`\n", path);
    fprintf(stderr, "%s:%d:\n", path, line);
    fprintf(stderr, "  is        %.*s\n", (int)strcspn(a, "\n"), a);
    fprintf(stderr, "  should be %.*s\n", (int)strcspn(b, "\n"), b);
}

int main(int argc, char** argv) {
    int check = argc > 1 && strcmp(argv[1], "--check") == 0;
    int first = 1 + check;
    if (argc < first + 2) { FAIL("usage: embed [--check] HEADER NN_NAME.glsl..."); }

    const char* path = argv[first];
    text header = read_file(path);
    text wanted = embed_all(path, &header, argc - first - 1, argv + first + 1);
    int same = header.size == wanted.size && memcmp(header.data, wanted.data, wanted.size) == 0;

    if (!same && check) { report_difference(path, &header, &wanted); }
    if (!same && !check) { write_file(path, &wanted); }
    free(header.data);
    free(wanted.data);
    return !same && check;
}
