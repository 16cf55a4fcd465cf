/* Replays recorded calls of the module without Python, and prints a checksum of the arrays after each call: so frames
 * can be drawn where there is a compiler for a processor, and an emulator, but no Python. Stands in for the functions of
 * the stable ABI that the module uses; recorded_calls.py writes the calls. */
#include <Python.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    PyObject base;
    char kind; /* i whole number, d number, a array, t tuple, c capsule, n None */
    long long whole;
    double number;
    void *pointer; /* of an array or capsule */
    Py_ssize_t size; /* bytes of an array, items of a tuple */
    PyObject **items;
} Object;

enum { MOST = 65536 };
static PyMethodDef *tables[8];
static int table_count, failed;
static Object *results[MOST];
PyObject *PyExc_ValueError;

static Object *made(char kind) {
    Object *object = calloc(1, sizeof *object);
    object->kind = kind;
    return object;
}

/* ---- the stable ABI ---- */

PyObject *PyModule_Create2(PyModuleDef *definition, int version) {
    (void)version;
    tables[table_count++] = definition->m_methods;
    return &made('n')->base;
}

int PyModule_AddFunctions(PyObject *module, PyMethodDef *methods) {
    (void)module;
    tables[table_count++] = methods;
    return 0;
}

int PyModule_AddStringConstant(PyObject *module, const char *name, const char *value) {
    (void)module, (void)name, (void)value;
    return 0;
}

int PyObject_GetBuffer(PyObject *object, Py_buffer *buffer, int flags) {
    (void)flags;
    memset(buffer, 0, sizeof *buffer);
    buffer->buf = ((Object *)object)->pointer;
    buffer->len = ((Object *)object)->size;
    return 0;
}

static const char *parse(Object *tuple, const char *format, va_list *to) {
    for (Py_ssize_t i = 0; *format != 0 && *format != ')'; i++, format++) {
        Object *object = (Object *)tuple->items[i];
        switch (*format) {
        case '(': format = parse(object, format + 1, to); break;
        case 'O': *va_arg(*to, PyObject **) = &object->base; break;
        case 'i': *va_arg(*to, int *) = (int)object->whole; break;
        case 'b': *va_arg(*to, unsigned char *) = (unsigned char)object->whole; break;
        case 'L': *va_arg(*to, long long *) = object->whole; break;
        case 'K': *va_arg(*to, unsigned long long *) = (unsigned long long)object->whole; break;
        case 'd': *va_arg(*to, double *) = object->kind == 'd' ? object->number : (double)object->whole; break;
        case 'y':
        case 'w': PyObject_GetBuffer(&object->base, va_arg(*to, Py_buffer *), 0), format++; break;
        default: fprintf(stderr, "unknown format %s\n", format), exit(1);
        }
    }
    return format;
}

int PyArg_ParseTuple(PyObject *arguments, const char *format, ...) {
    va_list to;
    va_start(to, format);
    parse((Object *)arguments, format, &to);
    va_end(to);
    return 1;
}

int PyArg_VaParse(PyObject *arguments, const char *format, va_list given) {
    va_list to;
    va_copy(to, given);
    parse((Object *)arguments, format, &to);
    va_end(to);
    return 1;
}

Py_ssize_t PyTuple_Size(PyObject *tuple) { return ((Object *)tuple)->size; }
PyObject *PyTuple_GetItem(PyObject *tuple, Py_ssize_t index) { return ((Object *)tuple)->items[index]; }

PyObject *PyTuple_GetSlice(PyObject *tuple, Py_ssize_t first, Py_ssize_t last) {
    Object *slice = made('t');
    slice->size = last - first;
    slice->items = ((Object *)tuple)->items + first;
    return &slice->base;
}

PyObject *Py_BuildValue(const char *format, ...) { return (void)format, &made('n')->base; }
void Py_DecRef(PyObject *object) { (void)object; }
void PyBuffer_Release(Py_buffer *buffer) { (void)buffer; }

PyObject *PyCapsule_New(void *pointer, const char *name, PyCapsule_Destructor destructor) {
    (void)name, (void)destructor;
    Object *object = made('c');
    object->pointer = pointer;
    return &object->base;
}

void *PyCapsule_GetPointer(PyObject *capsule, const char *name) { return (void)name, ((Object *)capsule)->pointer; }
PyObject *PyErr_Occurred(void) { return failed ? &made('n')->base : NULL; }
void PyErr_SetString(PyObject *type, const char *text) { (void)type, failed = 1, fprintf(stderr, "%s\n", text); }
PyObject *PyErr_Format(PyObject *type, const char *text, ...) { return PyErr_SetString(type, text), NULL; }
PyObject *PyErr_NoMemory(void) { return PyErr_SetString(NULL, "no memory"), NULL; }

/* ---- the recording ---- */

static int64_t read_whole(void) {
    unsigned char bytes[8];
    uint64_t value = 0;
    if (fread(bytes, 1, 8, stdin) != 8) exit(failed);
    for (int i = 7; i >= 0; i--) value = value << 8 | bytes[i];
    return (int64_t)value;
}

static Object *read_object(void) {
    Object *object = made((char)read_whole());
    if (object->kind == 'c') return results[read_whole()];
    int64_t value = read_whole();
    object->whole = value;
    memcpy(&object->number, &value, sizeof value);
    object->size = (Py_ssize_t)value;
    if (object->kind == 'a') {
        object->pointer = malloc((size_t)value + 1);
        if (fread(object->pointer, 1, (size_t)value, stdin) != (size_t)value) exit(1);
    } else if (object->kind == 't') {
        object->items = calloc((size_t)value + 1, sizeof *object->items);
        for (int64_t i = 0; i < value; i++) object->items[i] = &read_object()->base;
    }
    return object;
}

/* Adler-32 over the arrays among the arguments. */
static uint32_t checksum(const Object *tuple) {
    uint32_t a = 1, b = 0;
    for (Py_ssize_t i = 0; i < tuple->size; i++) {
        const Object *object = (const Object *)tuple->items[i];
        const unsigned char *bytes = object->pointer;
        for (Py_ssize_t k = 0; object->kind == 'a' && k < object->size; k++) b = (b + (a = (a + bytes[k]) % 65521)) % 65521;
    }
    return b << 16 | a;
}

static PyCFunction function_of(const char *name) {
    for (int i = 0; i < table_count; i++)
        for (PyMethodDef *method = tables[i]; method->ml_name != NULL; method++)
            if (strcmp(method->ml_name, name) == 0) return method->ml_meth;
    fprintf(stderr, "no function %s\n", name);
    exit(1);
}

PyObject *PyInit__core(void);

int main(void) {
    PyInit__core();
    for (int call = 0; call < MOST; call++) {
        Object *name = read_object(), *arguments = read_object();
        ((char *)name->pointer)[name->size] = 0;
        results[call] = (Object *)function_of(name->pointer)(NULL, &arguments->base);
        printf("%s %08x\n", (char *)name->pointer, checksum(arguments));
        for (Py_ssize_t i = 0; i < arguments->size; i++)
            if (((Object *)arguments->items[i])->kind == 'a') free(((Object *)arguments->items[i])->pointer);
    }
    return 1;
}
